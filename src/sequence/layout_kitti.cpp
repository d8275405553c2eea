// KITTI odometry, one sequence (A. Geiger, P. Lenz, R. Urtasun, CVPR 2012): image_0/ (else
// image_2/), times.txt, calib.txt with the projection matrices of the rectified cameras. The poses
// of camera 0 are a file of their own, poses/NN.txt next to sequences/, or poses.txt in the folder.
#include <algorithm>
#include <array>

#include "sequence/image_file.h"
#include "sequence/layout.h"
#include "sequence/text_lines.h"

namespace eifmap {
namespace fs = std::filesystem;
namespace {

using Matrix34 = std::array<double, 12>;  // row-major

bool is_folder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

bool recognizes(const fs::path& folder) {
  return is_folder(folder / "image_0") || is_folder(folder / "image_2");
}

// P0 or P2 of calib.txt.
std::string read_projection(const fs::path& file, const std::string& name, Matrix34& projection) {
  bool found = false;
  std::string problem = for_each_line(file, [&](const auto& words) -> std::string {
    if (words[0] != name + ":") return "";
    found = true;
    return read_numbers(words, 1, projection.size(), projection.data());
  });
  if (problem.empty() && !found)
    problem = file.string() + ": has no line '" + name + ":'; wanted it with 12 numbers";
  return problem;
}

std::string make_camera(const Matrix34& p, const fs::path& file, Recording& recording) {
  const GrayImage first = read_gray(recording.images.front());
  if (!first.problem.empty()) return first.problem;
  Camera camera;
  camera.width = first.image.cols;
  camera.height = first.image.rows;
  camera.fx = p[0];
  camera.fy = p[5];
  camera.cx = p[2];
  camera.cy = p[6];
  recording.camera = camera;
  recording.calibration = file.filename().string();
  const std::string problem = camera.problem();
  return problem.empty() ? "" : file.string() + ": " + problem;
}

// The camera's centre in the frame of camera 0; P = K [I | -centre] for rectified cameras.
Eigen::Vector3d centre_of(const Matrix34& p) {
  const double z = p[11];
  return {-(p[3] - p[2] * z) / p[0], -(p[7] - p[6] * z) / p[5], -z};
}

fs::path find_poses(const fs::path& folder) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(folder, error);
  for (const fs::path& file : {whole / "poses.txt", whole.parent_path().parent_path() / "poses" /
                                                        (whole.filename().string() + ".txt")})
    if (fs::is_regular_file(file, error)) return file;
  return {};
}

// Row by row the 3x4 matrix world_from_camera0, a line an image.
std::string read_poses(const fs::path& file, const Eigen::Vector3d& centre, Recording& recording) {
  std::vector<Rigid3> poses;
  const std::string problem = for_each_line(file, [&](const auto& words) -> std::string {
    Matrix34 m;
    if (std::string wrong = read_numbers(words, 0, m.size(), m.data()); !wrong.empty())
      return wrong;
    Eigen::Matrix3d rotation;
    rotation << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
    if (!((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-2))
      return "is no pose; wanted 12 numbers, a rotation and a translation row by row";
    poses.push_back(Rigid3(Eigen::Quaterniond(rotation).normalized(), {m[3], m[7], m[11]}) *
                    Rigid3(Eigen::Quaterniond::Identity(), centre));
    return "";
  });
  if (!problem.empty()) return problem;
  if (poses.size() != recording.images.size())
    return file.string() + ": has " + std::to_string(poses.size()) + " poses for " +
           std::to_string(recording.images.size()) + " images; wanted one each";
  for (std::size_t i = 0; i < poses.size(); ++i)
    recording.ground_truth.push_back({1e-6 * static_cast<double>(recording.times_us[i]), poses[i]});
  return "";
}

Recording read(const fs::path& folder, const SequenceOptions& options) {
  Recording recording;
  std::string& problem = recording.problem;
  const bool gray = is_folder(folder / "image_0");
  problem = list_images(folder / (gray ? "image_0" : "image_2"), recording.images);
  if (problem.empty()) problem = read_times(folder / "times.txt", recording);
  if (!problem.empty()) return recording;
  std::error_code error;
  const fs::path calibration = folder / "calib.txt";
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  if (fs::exists(calibration, error)) {
    Matrix34 projection;
    problem = read_projection(calibration, gray ? "P0" : "P2", projection);
    if (options.calibration.empty() && problem.empty())
      problem = make_camera(projection, calibration, recording);
    if (problem.empty() && projection[0] > 0 && projection[5] > 0) centre = centre_of(projection);
    // With a calibration of one's own the file is wanted for the place alone, and may be wrong.
    if (!options.calibration.empty()) problem.clear();
  }
  if (const fs::path poses = find_poses(folder); problem.empty() && !poses.empty())
    problem = read_poses(poses, centre, recording);
  return recording;
}

}  // namespace

const Layout kKittiLayout{"KITTI odometry", "image_0/, times.txt and calib.txt", &recognizes,
                          &read};

}  // namespace eifmap
