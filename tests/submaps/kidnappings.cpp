// A camera that is covered and carried between two rooms again and again, and walks from the one to
// the other in the end: prints what became of it, and ends with 1 where a map was returned to, or
// merged, that was another, where a kidnapping was not survived, or the maps have not become one.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "submaps/carried_camera.h"
#include "support/random.h"

namespace eifmap::test {
namespace {

struct Limits {
  double rmse = 0.05;  // m; measured at most 0.020
  double alike = 0;
  bool walks = true;
  double towards = 0;  // rad, where one looks in the rooms: 0 along the passage
};

constexpr int kDark = 25;  // frames: longer than lost.new_map_after_s

struct Count {
  int kidnappings = 0, found = 0, begun = 0, lost = 0;
};

// Into the dark and out of it in another room, or elsewhere in the same.
void kidnap(CarriedCamera& camera, Room room, double towards, Random& random, Count& count) {
  const std::int64_t starts = camera.mapper().statistics().starts;
  camera.covered(kDark);
  const double at = towards + random.uniform(-0.4, 0.4), way = random.uniform() < 0.5 ? -0.5 : 0.5;
  const FrameResult last = camera.look_around(room, at, at + way, 16);
  ++count.kidnappings;
  if (last.state != TrackingState::kTracking)
    ++count.lost;
  else
    ++(camera.mapper().statistics().starts > starts ? count.begun : count.found);
}

bool run(int seed, const Limits& limits) {
  RoomWorldOptions options;
  options.seed = seed;
  options.alike = limits.alike;
  const RoomWorld world(options);
  CarriedCamera camera(world, MapperOptions());
  Random random(static_cast<std::uint64_t>(seed) + 1000);
  Count count;
  const double from = limits.towards - 0.8, to = limits.towards + 0.8;
  camera.look_around(Room::kA, from, to, 46);
  camera.covered(kDark);
  camera.look_around(Room::kB, from, to, 46);
  for (int i = 0; i < 6; ++i)
    kidnap(camera, i % 2 == 0 ? Room::kA : Room::kB, limits.towards, random, count);
  if (limits.walks) {
    kidnap(camera, Room::kA, limits.towards, random, count);
    camera.covered(kDark);
    camera.look_around(Room::kA, -0.3, 0, 9);
    camera.walk(0, 1, 140);
    camera.look_around(Room::kB, 0, 0.8, 23);
  }
  const MapperStatistics& s = camera.mapper().statistics();
  const CarriedCamera::Errors errors = camera.errors();
  std::printf(
      "seed %d: %d kidnappings: %d found again, %d new maps, %d lost; returned %d, merged %d, kept "
      "%d; %d poses in a map of elsewhere; %d of %d frames within %.4f m, at most %.4f\n",
      seed, count.kidnappings, count.found, count.begun, count.lost,
      static_cast<int>(s.submaps.returned), static_cast<int>(s.submaps.merged),
      static_cast<int>(s.submaps.kept), camera.poses_elsewhere(), errors.frames,
      static_cast<int>(s.frames), errors.rmse, errors.largest);
  for (const auto& [reason, number] : s.submaps.refused)
    std::printf("  refused %d: %s\n", static_cast<int>(number), describe(reason).name);
  if (!s.submaps.last.empty()) std::printf("  last: %s\n", s.submaps.last.c_str());
  for (const std::string& problem : camera.problems()) std::printf("  %s\n", problem.c_str());
  // A wrong merge, or pose, puts the one room over the other: metres. Two maps of one room may
  // merge.
  const bool is_one = !limits.walks || s.submaps.merged >= 1;
  return is_one && errors.rmse <= limits.rmse && camera.problems().empty() &&
         camera.poses_elsewhere() == 0 && count.lost == 0;
}

int main_checked(int argc, char** argv) {
  int first = 1, seeds = 2;
  Limits limits;
  bool stays = false;
  CLI::App app("What becomes of a camera that is carried between rooms", "kidnappings");
  app.add_option("--seeds", seeds, "runs");
  app.add_option("--first-seed", first, "the first of them");
  app.add_option("--rmse", limits.rmse, "m, of the final trajectory at most");
  app.add_option("--alike", limits.alike, "part of a wall that both rooms have in common, 0 to 1");
  app.add_option("--towards", limits.towards, "rad, where one looks in the rooms");
  app.add_flag("--stays", stays, "never walks through the passage: the rooms' maps stay apart");
  CLI11_PARSE(app, argc, argv);
  limits.walks = !stays;
  int bad = 0;
  for (int seed = first; seed < first + seeds; ++seed) bad += !run(seed, limits);
  std::printf("%d of %d runs are as they should be\n", seeds - bad, seeds);
  return bad == 0 ? 0 : 1;
}

}  // namespace
}  // namespace eifmap::test

int main(int argc, char** argv) {
  try {
    return eifmap::test::main_checked(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "kidnappings: %s\n", error.what());
    return 1;
  }
}
