// Feature frames with true poses: of the feature-level worlds, of the rendered ones, of a recorded
// folder.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "frame.h"
#include "geometry/camera.h"
#include "geometry/rigid3.h"

namespace eifmap::test {

// Standard deviation of the noise that seeds add to recorded keypoints, each axis.
inline constexpr double kJitterPx = 0.05;

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual int size() const = 0;
  virtual const Camera& camera() const = 0;
  virtual std::int64_t time_us(int i) const = 0;
  virtual std::optional<Rigid3> world_from_camera(int i) const = 0;
  // Which point a keypoint at (u, v) px is a picture of, and where that is (world); nothing where
  // nobody knows.
  virtual std::optional<int> point_at(std::int64_t, float, float) const { return std::nullopt; }
  virtual std::optional<Eigen::Vector3d> point(int) const { return std::nullopt; }
  // Whether one may go through the frames a second time.
  virtual bool goes_again() const { return true; }
  // In order, each once. Throws std::runtime_error when it cannot be read.
  virtual FeatureFrame frame(int i) const = 0;
};

struct SourceOptions {
  // sideways, forward, loop; lap, turn, tiles, block, rendered_corridor (rendered); street,
  // corridor (straight, the latter the same again each 40 m); a file of poses (.txt); or a folder
  std::string world = "sideways";
  std::string event = "none";  // of the rendered worlds (simulation/simulated_world.h)
  int frames = 0;              // the first so many; 0: as many as make the world's way
  int every = 1;               // take every n-th
  double wrong_share = 0.05;   // of the feature-level worlds' keypoints
  double noise_px = 0.5;       // of the feature-level worlds' keypoints
  double noise_ratio = 1;      // the same: noise over what the keypoints claim
  // The same: what the calibration that the mapper is told is off by, in the sigmas that
  // MeasurementOptions has by default.
  double calibration_off = 0;
  double drift_px = 0;  // the same: with the viewing direction
  // Rendered images are kept here as files and read the next time; empty: always rendered. To be
  // emptied by hand when the simulation changes.
  std::filesystem::path cache;
};

// `seed`: of the world; of a recorded folder, of 0.05 px of noise added to its keypoints, 0 none.
// Throws std::invalid_argument or std::runtime_error with a sentence.
std::unique_ptr<FrameSource> make_source(const SourceOptions& options, int seed);

}  // namespace eifmap::test
