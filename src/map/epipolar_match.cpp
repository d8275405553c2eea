#include "map/epipolar_match.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace eifmap {
namespace {

constexpr double kUnitSquared = 254.0 * 254.0;  // squared norm of a descriptor's bytes

// Best and second best so far.
struct Best {
  int other = -1;
  int distance = std::numeric_limits<int>::max(), second = std::numeric_limits<int>::max();

  void offer(int candidate, int d) {
    if (d < distance) {
      second = distance;
      distance = d;
      other = candidate;
    } else if (d < second) {
      second = d;
    }
  }
};

// Where x_j lies along the epipolar line of x_i: z_j x_j = z_i h + t with h = R x_i, and rho =
// 1/z_i in closed form. A match must lie in front of both cameras, within its noise.
bool in_front(const Eigen::Vector3d& h, const Eigen::Vector3d& t, const Eigen::Vector2d& x_j,
              double sigma) {
  const Eigen::Vector2d a = t.head<2>() - t.z() * x_j;
  const Eigen::Vector2d c = h.head<2>() - h.z() * x_j;
  const double squared = a.squaredNorm();
  if (!(squared > 0)) return false;
  const double rho = -a.dot(c) / squared;
  const double sigma_rho = sigma * std::abs(h.z()) / std::sqrt(squared);
  return rho > -3 * sigma_rho && h.z() + rho * t.z() > 0;
}

bool convincing(const Best& best, const EpipolarMatchOptions& options) {
  return best.other >= 0 &&
         best.distance <= options.max_distance * options.max_distance * kUnitSquared &&
         best.distance <= options.max_ratio * options.max_ratio * best.second;
}

}  // namespace

std::vector<Match> match_along_epipolar_lines(const ObservedFrame& frame_i,
                                              const std::vector<int>& i,
                                              const ObservedFrame& frame_j,
                                              const std::vector<int>& j, const Rigid3& world_from_i,
                                              const Rigid3& world_from_j,
                                              const EpipolarMatchOptions& options) {
  const Rigid3 j_from_i = world_from_j.inverse() * world_from_i;
  if (!(j_from_i.translation.norm() > 0))
    throw std::invalid_argument("match_along_epipolar_lines: the two centres coincide");
  const Eigen::Matrix3d rotation = j_from_i.matrix();
  const Eigen::Matrix3d essential = skew(j_from_i.translation) * rotation;

  std::vector<Best> best_of_i(i.size()), best_of_j(j.size());
  for (std::size_t a = 0; a < i.size(); ++a) {
    Eigen::Vector3d line = essential * frame_i.x[i[a]].homogeneous();
    line /= line.head<2>().norm();
    const Eigen::Vector3d h = rotation * frame_i.x[i[a]].homogeneous();
    const double variance_i = frame_i.sigma[i[a]] * frame_i.sigma[i[a]];
    const std::int8_t* descriptor = frame_i.descriptor(i[a]);
    const int sign = frame_i.sign(i[a]);
    for (std::size_t b = 0; b < j.size(); ++b) {
      if (frame_j.sign(j[b]) != sign) continue;
      const double error = line.dot(frame_j.x[j[b]].homogeneous());
      const double variance = variance_i + frame_j.sigma[j[b]] * frame_j.sigma[j[b]];
      if (!(error * error <= options.max_error * options.max_error * variance)) continue;
      if (!in_front(h, j_from_i.translation, frame_j.x[j[b]], std::sqrt(variance))) continue;
      const int distance = descriptor_distance(descriptor, frame_j.descriptor(j[b]));
      best_of_i[a].offer(static_cast<int>(b), distance);
      best_of_j[b].offer(static_cast<int>(a), distance);
    }
  }
  std::vector<Match> matches;
  for (std::size_t a = 0; a < i.size(); ++a) {
    const Best& best = best_of_i[a];
    if (convincing(best, options) && best_of_j[best.other].other == static_cast<int>(a))
      matches.push_back({i[a], j[best.other], best.distance});
  }
  return matches;
}

}  // namespace eifmap
