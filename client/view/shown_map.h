// The map as the pages have it, and what must change in it to be the map that has arrived.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "geometry/rigid3.h"
#include "published/published_map.h"

namespace eifmap {

// What a page needs of a keyframe and of a landmark, no more.
struct ShownKeyframe {
  Rigid3 map_from_camera;
  bool operator==(const ShownKeyframe& other) const;
};

struct ShownLandmark {
  std::int64_t anchor = 0;        // a keyframe's id
  std::array<float, 3> position;  // map units, in the anchor's camera frame
  int signed_observations = 0;    // keyframes that see it, times its Laplacian's sign
  float sigma = -1;               // map units, root of the position's summed variances; -1 unknown
  bool operator==(const ShownLandmark&) const = default;
};

struct MapChanges {
  std::vector<std::pair<std::int64_t, ShownKeyframe>> keyframes;  // new or moved, by id
  std::vector<std::pair<std::int64_t, ShownLandmark>> landmarks;  // new or changed, by id
  std::vector<std::int64_t> removed_keyframes, removed_landmarks;
};

class ShownMap {
 public:
  // Takes over the map; returns what that changed.
  MapChanges update(const PublishedMap& map);
  void clear();

  const std::map<std::int64_t, ShownKeyframe>& keyframes() const { return keyframes_; }
  const std::map<std::int64_t, ShownLandmark>& landmarks() const { return landmarks_; }

 private:
  std::map<std::int64_t, ShownKeyframe> keyframes_;
  std::map<std::int64_t, ShownLandmark> landmarks_;
};

}  // namespace eifmap
