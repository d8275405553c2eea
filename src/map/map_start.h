// The start of a map from a set of first images: [WD10] IV, first paragraph.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "map/map.h"
#include "map/planar_start.h"

namespace eifmap {

struct StartedMap {
  Map map;  // two keyframes: the anchor and the newest frame
  // The frames before the newest that could be posed backwards in the new map, by age; the anchor
  // is among them.
  std::vector<TimedPose> posed;
};

// Of the frames that a start is offered: by merit it may choose the other sign.
MapSign sign_to_start_with(MapSignChoice choice);

struct StartStep {
  Reason reason = Reason::kTooFewFeatures;  // kNone: `started` holds a map
  std::string detail;                       // the numbers behind the reason
  int num_matches = 0;
  std::optional<StartedMap> started;
};

class MapStart {
 public:
  MapStart(const Camera& camera, const MapperOptions& options);

  // Compares the frame with the anchor; starts the map, or says why not yet.
  StartStep add(ObservedFrame observed);

  void reset() { frames_.clear(), anchor_ = 0; }

 private:
  void give_up_anchor();
  StartStep compare_with_anchor(ObservedFrame& observed);
  void choose_sign(MapSign sign, ObservedFrame& newest);

  Camera camera_;
  MapperOptions options_;
  PlanarStart planar_;
  std::deque<ObservedFrame> frames_;  // from the oldest kept to the newest
  std::size_t anchor_ = 0;            // in frames_
};

}  // namespace eifmap
