// How often landmarks are seen in tracked frames that should show them: what is hardly ever seen
// again is no landmark.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <vector>

#include "geometry/camera.h"
#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

// Whether the landmark is among the sights (by track ascending).
bool sees(const std::vector<LandmarkSight>& sights, int track);

// A rectangle in normalized image coordinates of which every place is in the image, with a margin:
// near its edge a blob is cut off and not found.
class SafeView {
 public:
  explicit SafeView(const Camera& camera);
  // Where the image's own features are.
  explicit SafeView(const ObservedFrame& observed);
  bool contains(const Eigen::Vector2d& x) const {
    return (x.array() >= min_.array()).all() && (x.array() <= max_.array()).all();
  }

 private:
  Eigen::Vector2d min_, max_;
};

// Of the landmarks `tracks`, in their order, those that the camera should see: within the view, and
// from about the distance and the side that their last sight was taken from, so that they look
// alike.
std::vector<int> landmarks_expected(const Map& map, const SafeView& view,
                                    const Rigid3& world_from_camera,
                                    const std::vector<int>& tracks);

// The counts live beside the map, which never changes while frames are tracked on it.
class SightCounts {
 public:
  explicit SightCounts(const Camera& camera) : view_(camera) {}

  // A tracked frame. One from where another was counted already tells nothing new and is left out:
  // a landmark is not lost by standing still where it happens to be missed.
  void add(const Map& map, const Tracking& tracking);

  void make_metric(double metres_per_unit) {
    if (last_) last_->translation *= metres_per_unit;
  }

  // Where the frame counted last was is not known any more: the next one counts.
  void forget_last() { last_.reset(); }

  // Those of another map, which is in this one now.
  void include(const SightCounts& other, const Appended& appended);
  const SafeView& view() const { return view_; }

  // The landmarks seen in less than a quarter of the frames that should show them; ascending.
  std::vector<int> hardly_seen(const Map& map) const;

 private:
  struct Count {
    int expected = 0, seen = 0;
  };
  bool is_elsewhere(const Map& map, const Tracking& tracking) const;
  void forget_removed(const Map& map);

  SafeView view_;
  std::map<int, Count> counts_;  // by track
  std::optional<Rigid3> last_;   // pose of the frame counted last
};

}  // namespace eifmap
