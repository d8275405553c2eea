// What two views of known homography say about keypoints: found again, matched right, how near.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "features/matcher.h"

namespace eifmap::testing {

using Places = std::vector<Keypoint>;  // of an image, whichever detector; laplacian_sign 0: unknown
using IndexPairs = std::vector<std::pair<int, int>>;  // of matches

struct PairFigures {
  int repeated = 0, visible = 0;     // keypoints of a found again in b, of those in b's view
  int matches = 0, right = 0;        // by descriptors; right: within 2 px
  double squares = 0, whitened = 0;  // sums over the right ones of squared errors, px^2 and 1

  // Of the right ones, each axis: px, and in units of what the keypoints say.
  double rms() const { return std::sqrt(squares / (2 * right)); }
  double whitened_rms() const { return std::sqrt(whitened / (2 * right)); }
  double repeatability() const { return static_cast<double>(repeated) / visible; }
  double precision() const { return static_cast<double>(right) / matches; }

  PairFigures& operator+=(const PairFigures& other) {
    repeated += other.repeated;
    visible += other.visible;
    matches += other.matches;
    right += other.right;
    squares += other.squares;
    whitened += other.whitened;
    return *this;
  }
};

// Where a point of a is in b, px, and how many times as large.
struct Mapped {
  Eigen::Vector2d place;
  double zoom;
};

inline Mapped map_point(const Eigen::Matrix3d& b_from_a, double u, double v) {
  const Eigen::Vector3d p = b_from_a * Eigen::Vector3d(u, v, 1);
  // |Jacobian| of a homography.
  return {p.hnormalized(), std::sqrt(std::abs(b_from_a.determinant() / std::pow(p.z(), 3)))};
}

inline PairFigures compare(const Places& a, const Places& b, const IndexPairs& matches,
                           const Eigen::Matrix3d& b_from_a, int width, int height) {
  PairFigures figures;
  for (const Keypoint& k : a) {
    const auto [p, zoom] = map_point(b_from_a, k.u, k.v);
    if (p.x() < 20 || p.y() < 20 || p.x() > width - 21 || p.y() > height - 21) continue;
    ++figures.visible;
    figures.repeated += std::any_of(b.begin(), b.end(), [&, &at = p, &z = zoom](const Keypoint& q) {
      return std::hypot(q.u - at.x(), q.v - at.y()) < 1 && q.laplacian_sign == k.laplacian_sign &&
             std::abs(std::log(q.scale / (z * k.scale))) < 0.4;
    });
  }
  for (const auto& [i, j] : matches) {
    const Keypoint& k = a[static_cast<std::size_t>(i)];
    const Keypoint& q = b[static_cast<std::size_t>(j)];
    const double square =
        (map_point(b_from_a, k.u, k.v).place - Eigen::Vector2d(q.u, q.v)).squaredNorm();
    ++figures.matches;
    if (square > 4) continue;
    ++figures.right;
    figures.squares += square;
    figures.whitened += square / (k.sigma_px * k.sigma_px + q.sigma_px * q.sigma_px);
  }
  return figures;
}

// As the mapper matches: within each sign.
inline IndexPairs match_signs(const FeatureFrame& a, const FeatureFrame& b) {
  IndexPairs pairs;
  for (const int sign : {-1, 1})
    for (const Match& m : match(features_of_sign(a, sign), features_of_sign(b, sign), {}))
      pairs.emplace_back(m.a, m.b);
  return pairs;
}

}  // namespace eifmap::testing
