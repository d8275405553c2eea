#include "degenerate/cases.h"

#include <tuple>
#include <vector>

namespace eifmap::test {
namespace {

SimulationOptions images(const char* world, const char* motion, int num_frames, double speed = 0) {
  SimulationOptions options;
  options.world = world;
  options.motion = motion;
  options.num_frames = num_frames;
  options.speed = speed;
  return options;
}

SimulationOptions with_event(SimulationOptions options, const char* event, double from_s,
                             double for_s) {
  options.event = event;
  options.event_from_s = from_s;
  options.event_for_s = for_s;
  return options;
}

constexpr double kForever = 1000;  // s

std::vector<Case> make_cases() {
  std::vector<Case> cases;
  const auto add = [&cases](const char* name, SimulationOptions world) -> Case& {
    cases.push_back({});
    cases.back().name = name;
    cases.back().world = std::move(world);
    return cases.back();
  };
  {
    Case& c = add("rotation", images("courtyard", "look_around", 360));
    c.from_s = 5, c.to_s = 13, c.tracked_after = 0.7;
  }
  {
    Case& c = add("rotation_first", images("courtyard", "pan", 160));
    c.begin = Begin::kNever;
    c.waits_with = Reason::kNoBaseline;
  }
  {
    Case& c = add("plane", images("wall", "sideways", 240));
    c.begin = Begin::kInTime;
    c.waits_with = Reason::kPlanarScene;
  }
  {
    Case& c = add("standstill", images("courtyard", "standstill", 120));
    c.begin = Begin::kNever;
    c.waits_with = Reason::kNoBaseline;
  }
  {
    Case& c = add("standstill_midway", images("courtyard", "pause", 580));
    c.from_s = 5.2, c.to_s = 25, c.tracked_after = 0.9;
    c.same_map_after = true;
    c.grows_during = false;
  }
  {
    Case& c = add("drive_slow", images("street", "drive", 240, 4));
    c.tracked_after = 0.9;
  }
  {
    Case& c = add("drive_fast", images("street", "drive", 140, 20));
    c.tracked_after = 0.9;
  }
  {
    Case& c = add("turn", images("courtyard", "turn", 160));
    c.from_s = 3.9, c.to_s = 4.6, c.start_by_s = 3;
  }
  {
    Case& c = add("bus", with_event(images("street", "sideways", 340), "bus", 6, 8));
    c.from_s = 6, c.to_s = 14, c.start_by_s = 6, c.tracked_after = 0.9;
    c.same_map_after = c.moves_during = true;
  }
  {
    Case& c = add("no_bus", images("street", "sideways", 340));
    c.start_by_s = 6, c.tracked_after = 0.9;
    c.stands_still = true;
  }
  {
    Case& c = add("bus_first", with_event(images("street", "sideways", 260), "bus", -4, 12));
    c.from_s = 0, c.to_s = 8, c.begin = Begin::kMaybe;
  }
  {
    Case& c = add("black", with_event(images("courtyard", "lap", 300, 0.8), "black", 6, 2));
    c.from_s = 6, c.to_s = 8, c.start_by_s = 5, c.tracked_after = 0.9;
    c.lost_during = c.same_map_after = true;
  }
  {
    Case& c = add("black_walking", with_event(images("courtyard", "lap", 300), "black", 6, 2));
    c.from_s = 6, c.to_s = 8, c.lost_during = true;
  }
  // Into the dark, and out of it where it has been long before.
  for (const auto& [name, world, motion, from] : {std::tuple{"kidnapped", "courtyard", "lap", 6.0},
                                                  {"kidnapped_street", "street", "drive", 6.0},
                                                  {"kidnapped_block", "block", "lap", 10.0}}) {
    const int num_frames = static_cast<int>(20 * (from + 6));
    Case& c = add(name, with_event(images(world, motion, num_frames), "kidnapped", from, 1));
    c.from_s = from, c.to_s = from + 1, c.tracked_after = 0.9;
    c.lost_during = c.same_map_after = true;
  }
  {
    Case& c = add("tiles", images("tiles", "lap", 240));
    c.begin = Begin::kMaybe;
  }
  {
    Case& c = add("covered", with_event(images("courtyard", "lap", 240), "covered", 5, kForever));
    c.from_s = 5, c.to_s = 5.05;
  }
  {
    Case& c =
        add("covered_first", with_event(images("courtyard", "lap", 200), "covered", 0, kForever));
    c.tracked_after = 0.5;
  }
  {
    Case& c = add("half_focal", images("courtyard", "lap", 240));
    c.focal_factor = 0.5;
    c.begin = Begin::kMaybe;
    c.calibration_suspect = true;
  }
  return cases;
}

}  // namespace

std::span<const Case> all_cases() {
  static const std::vector<Case> cases = make_cases();
  return cases;
}

const Case* find_case(const std::string& name) {
  for (const Case& which : all_cases())
    if (which.name == name) return &which;
  return nullptr;
}

}  // namespace eifmap::test
