// A map in use, with all that belongs to it, and what is left of one that was given up.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "map/loop_search.h"
#include "map/map.h"
#include "map/map_news.h"
#include "map/merge_search.h"
#include "map/sight_counts.h"
#include "map/tracking.h"
#include "map/tracking_history.h"
#include "map/trajectory_log.h"
#include "map_view.h"

namespace eifmap {

struct LiveMap {
  LiveMap(Map started, const Camera& camera);
  // All that is in the map's unit but the map itself, when that has become metric.
  void make_metric(double metres_per_unit);
  // The same when what is near each keyframe has grown by so much (Map::bend()); but `last`.
  void grow(const std::vector<double>& growth);
  // The books of another map, which is in this one now: not where the camera is.
  void include(const LiveMap& other, const Appended& appended, bool newest);
  // The camera of the map that has just been included, as the newest, is in this one.
  void follow(LiveMap&& other, const Appended& appended);
  // Never written to once it is here: a job may be reading it.
  const Map& map() const { return *current; }

  std::shared_ptr<Map> current;
  MapNews news;                     // while no job has them
  std::optional<MapUpdate> update;  // of the job adopted last, until it is asked for
  TrajectoryLog log;
  TrackingHistory history;
  SightCounts sight_counts;
  LoopSearch loop_search;         // while no job has it
  MergeSearch merge_search;       // the same
  std::vector<int> most_tracked;  // by keyframe: landmarks that the best frame tracked from there
  // What the bounds have cost (map_bounds.h).
  int removed_keyframes = 0, removed_landmarks = 0;
  bool full = false;         // no keyframe can go: none comes
  int wanted_when_full = 0;  // keyframes
  int reference = 0;         // keyframe that frames are related to
  LastMotion last;
  int next_to_try = 0;  // keyframe: relocalization goes round all of them
};

struct FinishedMap {
  std::vector<TimedPose> trajectory, keyframes;
  std::vector<MapPoint> points;
};

FinishedMap finish(const LiveMap& live);

// Where a lost camera may be in the map: the keyframes that look most like the image (at most
// `places`), the `likely` ones, and in turn some others, the fewer the more look like it: a frame's
// time stays bounded.
std::vector<int> keyframes_to_try(LiveMap& live, const FeatureFrame& frame, int places,
                                  const std::vector<int>& likely);

// The keyframe that shares the most of the frame's landmarks, if it is clearly a better reference
// than the present one: on a way back the old keyframes serve again.
int better_reference(const Map& map, const Tracking& tracking);

}  // namespace eifmap
