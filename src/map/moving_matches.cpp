#include "map/moving_matches.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/projection.h"
#include "geometry/robust.h"

namespace eifmap {
namespace {

struct Judged {
  Eigen::Vector2d x;      // in the frame, normalized
  Eigen::Vector2d error;  // from the nearest place where the scene would allow it
  double noise = 0;       // standard deviation of both places together, each axis
};

// Seen from the frame: all places between two depths along a ray of the keyframe.
class AllowedPlaces {
 public:
  AllowedPlaces(const Rigid3& world_from_keyframe, const Rigid3& world_from_frame, double nearest)
      : frame_from_keyframe_(world_from_frame.inverse() * world_from_keyframe), nearest_(nearest) {}

  // From the nearest of them to `seen`; false where the ray is not in front of the frame.
  bool error(const Eigen::Vector2d& in_keyframe, const Eigen::Vector2d& seen,
             Eigen::Vector2d& error) const {
    const Eigen::Vector3d ray = frame_from_keyframe_.rotation * in_keyframe.homogeneous();
    const Eigen::Vector3d near = nearest_ * ray + frame_from_keyframe_.translation;
    if (ray.z() < kInFront * ray.norm() || near.z() < kInFront * near.norm()) return false;
    const Eigen::Vector2d from = ray.hnormalized(), along = near.hnormalized() - from;
    const double length2 = along.squaredNorm();
    const double part =
        length2 > 0 ? std::clamp((seen - from).dot(along) / length2, 0.0, 1.0) : 0.0;
    error = seen - from - part * along;
    return true;
  }

 private:
  static constexpr double kInFront = 0.1;
  Rigid3 frame_from_keyframe_;
  double nearest_;
};

// A quarter of the depth that all but a few of the keyframe's landmarks exceed; 0 without any.
double nearest_depth(const Map& map, int keyframe) {
  std::vector<double> depths = map.depths(keyframe);
  if (depths.empty()) return 0;
  const auto low = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 20);
  std::nth_element(depths.begin(), low, depths.end());
  return 0.25 * *low;
}

std::vector<Judged> judge_matches(const Map& map, const ObservedFrame& observed,
                                  const Tracking& tracking) {
  const Keyframe& keyframe = map.keyframe(tracking.related);
  const AllowedPlaces allowed(map.pose(tracking.related), tracking.world_from_camera,
                              nearest_depth(map, tracking.related));
  const Projector projector(tracking.world_from_camera);
  std::vector<Judged> judged;
  for (const auto* matches : {&tracking.pair.p, &tracking.pair.m})
    for (const Match& match : *matches) {
      const Eigen::Vector2d& x = observed.x[match.b];
      Judged j{x, {}, std::hypot(keyframe.observed().sigma[match.a], observed.sigma[match.b])};
      const int track = keyframe.track[match.a];
      if (track != kNoTrack && map.track(track).is_landmark()) {
        Eigen::Vector2d predicted;
        if (!projector(map.position(track), predicted)) continue;
        j.error = x - predicted;
      } else if (!allowed.error(keyframe.observed().x[match.a], x, j.error)) {
        continue;
      }
      judged.push_back(j);
    }
  return judged;
}

// What no place in the scene explains, nor the poses and the lens, which are not perfect either:
// how far off they are all matches together show.
std::vector<Judged> strays_among(const std::vector<Judged>& judged, double radians_per_pixel) {
  constexpr double kSigmas = 5, kPixels = 3, kUsual = 10;
  std::vector<double> errors;
  for (const Judged& j : judged) errors.push_back(j.error.norm());
  const double least = std::max(kPixels * radians_per_pixel, kUsual * take_median(errors));
  std::vector<Judged> strays;
  for (const Judged& j : judged)
    if (j.error.norm() > std::max(least, kSigmas * j.noise)) strays.push_back(j);
  return strays;
}

// Neighbours on a thing that moves: near in the image, and with errors that are alike.
bool go_together(const Judged& a, const Judged& b, double radians_per_pixel) {
  constexpr double kNear = 0.15;  // rad: a part of the view; a car at 20 m is larger
  constexpr double kAlike = 0.25, kPixels = 3;
  if ((a.x - b.x).squaredNorm() > kNear * kNear) return false;
  const double larger = std::max(a.error.norm(), b.error.norm());
  return (a.error - b.error).norm() < std::max(kAlike * larger, kPixels * radians_per_pixel);
}

}  // namespace

int count_moving_matches(const Map& map, const ObservedFrame& observed, const Tracking& tracking) {
  constexpr int kNeighbours = 6;
  if (!tracking.ok()) return 0;
  const double radians_per_pixel = map.radians_per_pixel();
  const std::vector<Judged> strays =
      strays_among(judge_matches(map, observed, tracking), radians_per_pixel);
  const auto has_company = [&](const Judged& stray) {
    // It goes together with itself.
    return std::count_if(strays.begin(), strays.end(), [&](const Judged& other) {
             return go_together(stray, other, radians_per_pixel);
           }) > kNeighbours;
  };
  return static_cast<int>(std::count_if(strays.begin(), strays.end(), has_company));
}

}  // namespace eifmap
