// EuRoC MAV (M. Burri et al., IJRR 2016), and who else writes so: mav0/cam0/data.csv with the names
// in data/, sensor.yaml, and mav0/state_groundtruth_estimate0/data.csv, the body's poses.
#include <array>

#include "sequence/camera_file.h"
#include "sequence/layout.h"
#include "sequence/text_lines.h"

namespace eifmap {
namespace fs = std::filesystem;
namespace {

// The folder itself may be named, or the mav0 in it.
fs::path mav_of(const fs::path& folder) {
  std::error_code error;
  return fs::is_directory(folder / "mav0", error) ? folder / "mav0" : folder;
}

bool recognizes(const fs::path& folder) {
  std::error_code error;
  return fs::is_directory(folder / "mav0", error) || fs::is_directory(folder / "cam0", error);
}

// A line a pose: time (ns), position (m), quaternion (w first) of the body in the world; what
// follows is not about poses.
std::string read_truth(const fs::path& file, const Rigid3& body_from_camera,
                       std::vector<TumPose>& poses) {
  std::vector<std::int64_t> times_us;
  return for_each_line(file, [&](const auto& words) -> std::string {
    if (std::string wrong = add_nanoseconds(words[0], times_us); !wrong.empty()) return wrong;
    std::array<double, 7> n;
    if (std::string wrong = read_numbers(words, 1, n.size(), n.data()); !wrong.empty())
      return wrong;
    const Eigen::Quaterniond rotation(n[3], n[4], n[5], n[6]);
    if (!(std::abs(rotation.norm() - 1) < 0.01)) return "the quaternion is not of length 1";
    const Rigid3 world_from_body(rotation.normalized(), {n[0], n[1], n[2]});
    poses.push_back(
        {1e-6 * static_cast<double>(times_us.back()), world_from_body * body_from_camera});
    return "";
  });
}

Recording read(const fs::path& folder, const SequenceOptions& options) {
  Recording recording;
  const fs::path mav = mav_of(folder), camera = mav / "cam0";
  recording.problem =
      read_image_list(camera / "data.csv", camera / "data", add_nanoseconds, recording);
  if (!recording.problem.empty()) return recording;
  std::error_code error;
  const fs::path sensor_file = camera / "sensor.yaml";
  SensorFile sensor;
  const bool has_sensor = fs::exists(sensor_file, error);
  if (has_sensor) sensor = read_sensor(sensor_file);
  if (options.calibration.empty() && has_sensor) {
    recording.problem = sensor.problem;
    recording.camera = sensor.camera;
    recording.calibration = "sensor.yaml";
  }
  const fs::path truth = mav / "state_groundtruth_estimate0" / "data.csv";
  if (!recording.problem.empty() || !fs::exists(truth, error)) return recording;
  if (has_sensor && sensor.problem.empty())
    recording.problem = read_truth(truth, sensor.body_from_camera, recording.ground_truth);
  else
    recording.notes.push_back(truth.string() + " is passed over: without T_BS in " +
                              sensor_file.string() + " it is not known where the camera was");
  return recording;
}

}  // namespace

const Layout kEurocLayout{"EuRoC MAV", "mav0/ with cam0/data.csv, cam0/data/ and cam0/sensor.yaml",
                          &recognizes, &read};

}  // namespace eifmap
