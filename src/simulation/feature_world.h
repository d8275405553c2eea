// A world of points with descriptors that never change: what the mapper sees of a camera that moves
// among them, with exact truth and noise of a known size. For everything that is to be measured
// without images: consistency, long trajectories, wrong matches.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "frame.h"
#include "geometry/camera.h"
#include "geometry/rigid3.h"

namespace eifmap {

struct FeatureWorldOptions {
  // "sideways": along a facade. "forward": down a corridor. "loop": round a ring-shaped corridor,
  // looking ahead and a little inwards; a lap is 262 frames.
  std::string motion = "sideways";
  int num_frames = 100;
  double rate_hz = 10;
  int features = 400;     // about as many in an image as the world offers
  double noise_px = 0.5;  // standard deviation of a keypoint's place, each axis
  // What keypoints claim. With the mapper's sigma_factor it should make the noise.
  double sigma_px = 0.25;
  // A blob is not a point: seen from elsewhere its middle is another. Standard deviation of that
  // displacement, each axis, and how far the viewing direction must turn to make it a new one.
  double drift_px = 0, drift_angle_deg = 6;
  double repeatability = 0.85;  // chance that a point in view gives a keypoint
  double wrong_share = 0.05;    // of the keypoints: they wear the descriptor of another
  int max_features = 1000;      // the strongest are kept
  int seed = 1;                 // of everything that is drawn

  std::string problem() const;  // "" or which field is wrong and why
};

struct SimulatedFeatures {
  FeatureFrame frame;
  std::vector<int> point;  // per keypoint: what it is a picture of, whatever its descriptor says
};

// Of every feature world: a pinhole, 640x480.
Camera feature_world_camera();

class FeatureWorld {
 public:
  explicit FeatureWorld(const FeatureWorldOptions& options = {});  // throws std::invalid_argument

  int num_frames() const { return options_.num_frames; }
  const Camera& camera() const { return camera_; }                        // feature_world_camera()
  const std::vector<Eigen::Vector3d>& points() const { return points_; }  // world, m

  // Of frame i in [0, num_frames()); another i throws std::out_of_range. Frames are independent of
  // each other.
  std::int64_t time_us(int i) const;
  Rigid3 world_from_camera(int i) const;  // m
  SimulatedFeatures frame(int i) const;

 private:
  void check(int i) const;
  Eigen::Vector2d drift(int point, const Eigen::Vector3d& camera_centre) const;  // px

  FeatureWorldOptions options_;
  Camera camera_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<double> size_;              // m: a point's blob
  std::vector<std::int8_t> descriptors_;  // kDescriptorSize per point
};

}  // namespace eifmap
