#include "map/kept_maps.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace eifmap {

std::optional<KeptMap> KeptMaps::keep(KeptMap map) {
  maps_.push_back(std::move(map));
  if (size() <= most_) return std::nullopt;
  const auto keyframes = [](const KeptMap& m) { return m.live.map().num_keyframes_in_use(); };
  const auto least = std::min_element(
      maps_.begin(), maps_.end(),
      [&](const KeptMap& a, const KeptMap& b) { return keyframes(a) < keyframes(b); });
  return take(least->map_id);
}

KeptMap* KeptMaps::find(std::int64_t map_id) {
  const auto found = std::find_if(maps_.begin(), maps_.end(),
                                  [map_id](const KeptMap& m) { return m.map_id == map_id; });
  return found == maps_.end() ? nullptr : &*found;
}

KeptMap KeptMaps::take(std::int64_t map_id) {
  KeptMap* found = find(map_id);
  if (!found) throw std::out_of_range("KeptMaps: no such map");
  KeptMap map = std::move(*found);
  maps_.erase(maps_.begin() + (found - maps_.data()));
  return map;
}

KeptMap* KeptMaps::next_to_try() {
  return maps_.empty() ? nullptr : &maps_[static_cast<std::size_t>(turn_++ % size())];
}

std::vector<KeptView> KeptMaps::views() const {
  std::vector<KeptView> views;
  for (const KeptMap& map : maps_) views.push_back({map.map_id, map.live.current});
  return views;
}

}  // namespace eifmap
