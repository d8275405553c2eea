// eifmap's own: images/ in the order of their names, times.txt (seconds, a line an image),
// calib.json, and groundtruth.tum when there is one.
#include "sequence/image_file.h"
#include "sequence/layout.h"

namespace eifmap {
namespace fs = std::filesystem;
namespace {

bool recognizes(const fs::path& folder) {
  std::error_code error;
  return fs::is_directory(folder / "images", error);
}

Recording read(const fs::path& folder, const SequenceOptions& options) {
  Recording recording;
  std::string& problem = recording.problem;
  problem = list_images(folder / "images", recording.images);
  if (!problem.empty()) return recording;
  std::error_code error;
  const fs::path times = folder / "times.txt";
  if (fs::exists(times, error))
    problem = read_times(times, recording);
  else if (options.rate_hz > 0)
    assume_times(recording, options);
  else
    problem = times.string() +
              ": cannot be read; wanted a line an image, in seconds, or their rate by --rate HZ";
  if (!problem.empty()) return recording;
  if (options.calibration.empty()) read_own_calibration(folder, recording);
  const fs::path truth = folder / "groundtruth.tum";
  if (problem.empty() && fs::exists(truth, error)) {
    TumTrajectory trajectory = read_tum(truth);
    problem = trajectory.problem;
    recording.ground_truth = std::move(trajectory.poses);
  }
  return recording;
}

}  // namespace

const Layout kOwnLayout{"eifmap", "images/, times.txt and calib.json", &recognizes, &read};

}  // namespace eifmap
