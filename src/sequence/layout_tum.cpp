// TUM RGB-D (J. Sturm et al., IROS 2012): rgb.txt with times and names in rgb/, groundtruth.txt.
// The calibration is not in the folder; the data set's page gives one for each of its three
// cameras, which the folder's name tells.
#include <array>
#include <utility>

#include "sequence/layout.h"
#include "sequence/text_lines.h"

namespace eifmap {
namespace fs = std::filesystem;
namespace {

bool recognizes(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / "rgb.txt", error) || fs::is_directory(folder / "rgb", error);
}

Camera camera_of(double fx, double fy, double cx, double cy, const std::array<double, 5>& lens) {
  const auto model = lens[0] == 0 ? CameraModel::kPinhole : CameraModel::kRadialTangential;
  return {640, 480, model, fx, fy, cx, cy, lens};
}

// As the data set's page gives them for the colour images; those of the third are rectified.
std::optional<Camera> known_camera(const std::string& name) {
  const auto is = [&name](char number) {
    return name.find(std::string("freiburg") + number) != std::string::npos;
  };
  if (is('1'))
    return camera_of(517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633});
  if (is('2'))
    return camera_of(520.9, 521.0, 325.1, 249.7, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172});
  if (is('3')) return camera_of(535.4, 539.2, 320.1, 247.6, {});
  return std::nullopt;
}

Recording read(const fs::path& folder, const SequenceOptions& options) {
  Recording recording;
  recording.problem = read_image_list(folder / "rgb.txt", folder, add_seconds, recording);
  if (!recording.problem.empty()) return recording;
  std::error_code error;
  if (options.calibration.empty()) {
    const fs::path whole = fs::weakly_canonical(folder, error);
    const std::string name = (whole.has_filename() ? whole : whole.parent_path()).filename();
    recording.camera = known_camera(name);
    recording.calibration = "the calibration that the data set's page gives for " + name;
  }
  const fs::path truth = folder / "groundtruth.txt";
  if (!fs::exists(truth, error)) return recording;
  TumTrajectory trajectory = read_tum(truth);
  recording.problem = trajectory.problem;
  recording.ground_truth = std::move(trajectory.poses);
  return recording;
}

}  // namespace

const Layout kTumLayout{"TUM RGB-D", "rgb.txt and rgb/", &recognizes, &read};

}  // namespace eifmap
