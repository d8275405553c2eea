// The camera's roll from image to image, to level descriptors by: upright ones tell more and cost
// less than oriented ones, as long as up is up.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "features/features.h"
#include "features/matcher.h"
#include "features/turn_fit.h"
#include "geometry/camera.h"

namespace eifmap {

struct RollOptions {
  // A roll below this leaves descriptors upright, bit for bit; from twice that on they turn with
  // the image, in between twice as fast. Upright descriptors match as well as oriented ones to
  // about 10 degrees; at 15 a third is lost [measured on rendered pairs].
  double dead_band_deg = 10;

  std::string problem() const;  // "" or which field is wrong and why
};

// Matches each image's strongest features with those of a reference image and carries along which
// way is down: the first image's +v. When too few are left to match, or they fit no longer, the
// last image that did is the next reference. After a second or so without any match, as in the
// dark, +v is down again. A pure function of the images so far.
class RollFollower {
 public:
  explicit RollFollower(const RollOptions& options) : options_(options) {}

  // Descriptors of some keypoints in frames turned by `angle`.
  using Describe =
      std::function<std::vector<std::int8_t>(const std::vector<Keypoint>& keypoints, float angle)>;

  // The next image: its features, described at angle(), and how to describe them at another. From
  // then on angle() is the image's.
  void follow(const Features& features, const Camera& camera, const Describe& describe);

  // rad, +u towards +v: by how much to turn descriptors.
  float angle() const { return angle_; }
  // rad in [-pi, pi]: by how much the image is turned against the first one.
  double roll() const;
  // Whether the last image could be matched; else the roll is still that of the image before.
  bool sure() const { return sure_; }

 private:
  // An image's strongest features, the descriptors of each sign together, and its down.
  struct Strongest {
    std::vector<Keypoint> keypoints;
    std::vector<Eigen::Vector3d> bearings;
    std::array<FeatureGroup, 2> groups;
    Eigen::Vector3d down = Eigen::Vector3d::UnitY();  // unit, in the camera's frame

    Strongest() = default;
    Strongest(const Features& features, const Camera& camera);
    std::size_t size() const { return keypoints.size(); }
    void set_descriptors(const std::vector<std::int8_t>& descriptors);
  };

  bool match_with_reference(Strongest& image, double noise);
  bool match_turned(Strongest& image, double noise, const Describe& describe);
  void take_as_reference(Strongest image);
  void set_angle();

  RollOptions options_;
  Strongest reference_, last_;  // the last one that matched
  std::optional<Turn> turn_;    // of the last one against the reference
  int images_unmatched_ = 0;    // in a row, dark ones not counted
  int images_since_match_ = 0;
  float angle_ = 0;
  bool sure_ = true;
};

}  // namespace eifmap
