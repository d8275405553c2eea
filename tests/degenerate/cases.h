// What mapping with one camera finds hard, each with the state that it has to end in.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "reason.h"
#include "simulation/simulated_world.h"

namespace eifmap::test {

enum class Begin {
  kNever,   // no map
  kMaybe,   // a map, or it waits
  kInTime,  // a map, before start_by_s
};

struct Case {
  std::string name;
  SimulationOptions world;
  double focal_factor = 1;  // the calibration's focal length over the true one

  Begin begin = Begin::kInTime;
  double start_by_s = 4;
  // While there is no map this is what is mostly said.
  std::optional<Reason> waits_with;

  // What happens on the way, s: judged before `from`, and from `to` on. Ends before it begins: no
  // such thing.
  double from_s = 0, to_s = -1;
  bool lost_during = false;     // LOST is said in it
  bool same_map_after = false;  // else a new one will do, if LOST was said
  bool grows_during = true;     // false: the map stays as large as it is
  bool moves_during = false;    // something does: counted then, and not before
  bool stands_still = false;    // nothing moves: next to nothing is counted
  double tracked_after =
      0;  // share of the images from the start, or from `to` on, that have a pose
  // The calibration is wrong, and that is said if there is a map, which then may be wrong. Else it
  // is never said.
  bool calibration_suspect = false;
};

std::span<const Case> all_cases();
const Case* find_case(const std::string& name);

}  // namespace eifmap::test
