// How a camera has turned between two images, wherever it has gone meanwhile.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace eifmap {

// One point as two directions, unit vectors in the frames of cameras a and b.
struct BearingPair {
  Eigen::Vector3d a, b;
};

// Camera b in the frame of a: x_in_a = rotation x_in_b + (unknown length) direction.
struct Turn {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  // unit; arbitrary without parallax
};

struct TurnFit {
  Turn turn;
  double sigma = 0;     // rad, of the pairs' distances to their epipolar planes; at least `noise`
  int num_inliers = 0;  // pairs within 3 sigma
};

// Robust Gauss-Newton on the epipolar constraint, from `start` or, without one, from the rotation
// that brings the directions closest. That alone would not do: over ground that is nearer below, a
// step to the side looks like a turn about the optical axis. `noise`: rad, standard deviation of a
// direction. Needs 8 pairs, most of them right, else nothing fits: there is no random search.
TurnFit fit_turn(std::span<const BearingPair> pairs, double noise,
                 const std::optional<Turn>& start);

}  // namespace eifmap
