// Follows the map of the first camera that is heard, and says what changes in it.
//   follow_map [LCM_URL]
#include <eifmap/map_client.h>

#include <cstdio>
#include <lcm/lcm-cpp.hpp>

int main(int argc, char** argv) {
  lcm::LCM lcm(argc > 1 ? argv[1] : "udpm://239.255.76.67:7667?ttl=0");
  if (!lcm.good()) {
    std::fprintf(stderr, "LCM cannot be opened; is there a route for multicast?\n");
    return 1;
  }
  eifmap::MapClient client(lcm, "");
  client.on_change([&](const eifmap::MapChange& change) {
    const eifmap::PublishedMap& map = client.map();
    std::printf("%s: map %ld, update %ld%s: %zu keyframes, %zu landmarks\n",
                client.camera().c_str(), long{map.map_id()}, long{map.seq()},
                change.whole ? " (whole)" : "", map.keyframes().size(), map.landmarks().size());
    double position[3];
    for (const std::int64_t id : change.landmarks)
      if (const auto landmark = map.landmarks().find(id);
          landmark != map.landmarks().end() && argc > 2 &&
          position_in_map(map, landmark->second.value, position))
        std::printf("  %ld is at %.3f %.3f %.3f\n", long{id}, position[0], position[1],
                    position[2]);
    std::fflush(stdout);
  });
  while (lcm.handleTimeout(50) >= 0) client.tick();
  return 1;
}
