// A tracked frame becomes part of the map: [WD10] Algorithm 2, steps 2-4.
#pragma once

#include <memory>
#include <vector>

#include "map/innovations.h"
#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

// Whether the frame should become a keyframe: too little of the reference is left, or the camera
// has moved far enough to see depth. Never on few inliers or an uncertain place: a map built on
// sand jumps in scale without a word.
struct Usual {
  int most_tracked = 0;   // landmarks that the best frame so far tracked from the reference
  bool odd_step = false;  // to this frame: see TrackingHistory
};
bool wants_keyframe(const Map& map, const Tracking& tracking, const Usual& usual,
                    const MapperOptions& options);

struct Insertion {
  int keyframe = 0;
  // Or kFilterFailed, kScaleJump: the map is not to be trusted. Or kMapFull: no room could be made,
  // and it is as it was.
  Reason reason = Reason::kNone;
  Innovations innovations;                           // of its measurements, before the update
  int removed_keyframes = 0, removed_landmarks = 0;  // to stay within the bounds
};

// Pose, measurements, relative-pose edge, new features, update of the filter, culling: also of the
// landmarks (tracks) that were `hardly_seen` in the frames before (SightCounts).
Insertion insert_keyframe(Map& map, std::shared_ptr<const ObservedFrame> observed,
                          const Tracking& tracking, const std::vector<int>& hardly_seen,
                          const MapperOptions& options);

struct TrackExtension {
  double sigma_centre = 0;    // standard deviation of the keyframe's place, map units
  bool few_tracked = false;   // landmarks: min_views_if_few is enough for a new one
  bool with_omega_p = false;  // features of Omega_p that no edge has used may become landmarks too
};

// Step 3 alone: matches the newest keyframe with its neighbours, extends tracks, and promotes what
// is seen well enough. Returns the number of new landmarks.
int extend_tracks(Map& map, int keyframe, const MapperOptions& options,
                  const TrackExtension& extension = {});

// One relative-pose edge from the matches of two keyframes, of measurements that no edge has used.
// `matches`: a in i, b in j; those that fit `start`. False when too few are left or the direction
// is not certain enough.
bool add_edge(Map& map, int i, int j, const std::vector<Match>& matches, RelativePose start,
              const MapperOptions& options);

// The same for a pair that was not matched yet: the map's poses guide the matching and are the
// start of the refinement, no part of the measurement.
bool add_edge_from_map(Map& map, int i, int j, const MapperOptions& options);

}  // namespace eifmap
