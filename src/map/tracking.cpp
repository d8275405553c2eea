#include "map/tracking.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "map/image_shift.h"
#include "map/other_place.h"
#include "map/pose_search.h"

namespace eifmap {
namespace {

// The place with which the most agrees, unless another is nearly as good. A camera that was lost,
// or that its reference is not sure of, may be anywhere: none of them is the more likely one for
// being near.
Tracking only_place(const Map& map, std::vector<Tracking> places, const MapperOptions& options) {
  const auto agree = [](const Tracking& place) { return static_cast<int>(place.sights.size()); };
  const auto best =
      std::max_element(places.begin(), places.end(),
                       [&](const Tracking& a, const Tracking& b) { return agree(a) < agree(b); });
  for (const Tracking& other : places)
    if (choose_place(agree(*best), agree(other)) != PlaceChoice::kFar &&
        median_shift(map, best->sights, best->world_from_camera, other.world_from_camera) >
            search_radius(map, options)) {
      refuse_as_ambiguous(other, *best);
      break;
    }
  return std::move(*best);
}

}  // namespace

Tracking track_frame(const Map& map, const ObservedFrame& observed, int reference,
                     const LastMotion& last, const MapperOptions& options, int neighbours) {
  const PoseSearch search(map, observed, last, options);
  Tracking tracking;
  const auto found_against = [&search](int keyframe, Tracking& result) {
    if (!search.against(keyframe, result)) return false;
    search.compare_with_nearer(result);
    return true;
  };
  // Around a wrong place some landmarks agree by chance, as many as that around another.
  const auto is_sure = [&options](const Tracking& place) {
    return place.ok() && static_cast<int>(place.sights.size()) >= options.lost.min_inliers;
  };
  const bool found = found_against(reference, tracking);
  if ((found && is_sure(tracking)) || neighbours == 0) return tracking;
  // Another view of the same place may match where this one does not.
  std::vector<int> others = map.covisible(reference, neighbours);
  if (std::find(others.begin(), others.end(), map.newest()) == others.end())
    others.push_back(map.newest());
  std::vector<Tracking> places;
  for (int other : others) {
    Tracking place;
    if (other == reference || !found_against(other, place)) continue;
    if (!found || is_sure(place)) places.push_back(std::move(place));
  }
  return places.empty() ? tracking : only_place(map, std::move(places), options);
}

Tracking relocalize(const Map& map, const ObservedFrame& observed,
                    const std::vector<int>& keyframes, const MapperOptions& options) {
  const LastMotion unknown;
  const PoseSearch search(map, observed, unknown, options);
  std::vector<Tracking> places;
  for (int k : keyframes) {
    Tracking tracking;
    tracking.reference = tracking.related = k;
    const std::vector<LandmarkSight> sights =
        landmarks_among(map, k, match_omega_m(map.keyframe(k).observed(), observed, options.match));
    if (static_cast<int>(sights.size()) < options.absolute_pose.min_inliers) continue;
    if (!search.by_pnp(sights, PoseSource::kRelocalized, tracking)) continue;
    if (static_cast<int>(tracking.sights.size()) >= options.lost.min_inliers)
      places.push_back(std::move(tracking));
  }
  if (!places.empty()) return only_place(map, std::move(places), options);
  Tracking tracking;
  tracking.reason = Reason::kNotRelocalized;
  tracking.source = PoseSource::kNone;
  tracking.sights.clear();
  std::ostringstream detail;
  detail << "none of " << keyframes.size() << " keyframes tried has " << options.lost.min_inliers
         << " map features that agree";
  tracking.detail = detail.str();
  return tracking;
}

}  // namespace eifmap
