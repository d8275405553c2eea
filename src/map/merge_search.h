// Whether what the newest keyframe of one map shows is in another map, which was kept when the
// camera was lost.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "map/loop_gate.h"
#include "map/map.h"
#include "map/sight_counts.h"
#include "options.h"

namespace eifmap {

struct KeptView {
  std::int64_t map_id = 0;
  std::shared_ptr<const Map> map;
};

// Null where it is not among them.
const Map* map_of(std::int64_t map_id, const std::vector<KeptView>& kept);

// Where keyframes in a row of the map in use are in a kept map.
struct MapsFit {
  bool found = false;             // a place that seems to be in the kept map
  Reason reason = Reason::kNone;  // or why it is not believed
  std::string detail;             // with its numbers
  std::int64_t map_id = 0;        // the kept map's
  std::vector<LoopFit> fits;      // fit_place(), by age: all agree on how the two maps fit
  bool ok() const { return found && reason == Reason::kNone; }
};

// How the map of the fit's keyframe is turned, moved and scaled into that of its old place.
Similarity there_from_here(const LoopFit& fit, const Map& here);

// Whether two fits say the same of two maps, by their covariances, that of `here` between the two
// keyframes, and what a calibration may add.
bool agree(const LoopFit& a, const LoopFit& b, const Map& there, const Map& here,
           const LoopOptions& options);

// Remembers what the keyframes before have found: several in a row must agree.
class MergeSearch {
 public:
  // Matches `newest` with at most options.loop.max_candidates keyframes of the kept maps, in turn
  // of all of them, and with those around where the keyframe before was found.
  MapsFit look(const Map& here, int newest, const std::vector<KeptView>& kept, const SafeView& view,
               const MapperOptions& options);
  void begin_anew() { *this = MergeSearch(turn_); }
  MergeSearch() = default;

 private:
  struct Place {
    std::int64_t map_id = 0;
    int keyframe = -1;
    bool operator==(const Place&) const = default;
  };
  explicit MergeSearch(int turn) : turn_(turn) {}
  std::vector<Place> to_try(const Map& here, int newest, const std::vector<KeptView>& kept,
                            const LoopOptions& options) const;
  void forget_changed(const Map& here, const std::vector<KeptView>& kept);

  Place place_;   // found by the keyframe before
  int seen_ = 0;  // keyframes in a row
  std::vector<LoopFit> fits_;
  int epoch_ = 0;  // of the map in use
  int turn_ = 0;
};

}  // namespace eifmap
