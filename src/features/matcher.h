// Matching within a Laplacian sign: the two groups Omega_p and Omega_m of [WD10] II never mix.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "frame.h"

namespace eifmap {

// Squared distance of two int8 descriptors (kDescriptorSize bytes each). A unit vector's bytes have
// norm 254, so 2 * 254^2 = 129032 is "orthogonal".
int descriptor_distance(const std::int8_t* a, const std::int8_t* b);
// The same of one to each of `count` others, which follow each other.
void descriptor_distances(const std::int8_t* from, const std::int8_t* to, int count, int* result);

// The features of one sign of a frame: a contiguous copy of their descriptors and where they came
// from.
struct FeatureGroup {
  std::vector<int> index;                // keypoint in the frame
  std::vector<std::int8_t> descriptors;  // kDescriptorSize per entry of index
  int size() const { return static_cast<int>(index.size()); }
};

// [WD10] II: Lambda = [Lambda_p, Lambda_m] by the sign of the Laplacian.
FeatureGroup features_of_sign(const FeatureFrame& frame, int laplacian_sign);

struct MatchOptions {
  double max_ratio = 0.8;     // of the distance (not squared) to that of the second best
  double max_distance = 0.6;  // of unit vectors, not squared
  bool mutual = true;         // each is the other's best

  std::string problem() const;
};

struct Match {
  int a = 0, b = 0;  // keypoint indices in the two frames
  int distance = 0;  // squared, as descriptor_distance
};

// All of a against all of b; sorted by a. Deterministic: ties go to the lower index.
std::vector<Match> match(const FeatureGroup& a, const FeatureGroup& b, const MatchOptions& options);

// Buckets of points for 'which are within r of here'. Positions in any unit.
class PointGrid {
 public:
  PointGrid() = default;
  // `points`: positions; ids handed out are their indices. `cell`: side of a bucket > 0.
  PointGrid(std::span<const Eigen::Vector2d> points, double cell);

  // Indices within `radius` of x, ascending.
  void near(const Eigen::Vector2d& x, double radius, std::vector<int>& found) const;

 private:
  std::vector<Eigen::Vector2d> points_;
  std::vector<int> start_, order_;  // order_[start_[c] .. start_[c+1]): points of bucket c
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  double cell_ = 1;
  int columns_ = 0, rows_ = 0;
};

}  // namespace eifmap
