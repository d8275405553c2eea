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
    std::printf("%s: map %ld, update %ld%s: %zu keyframes, %zu landmarks; %zu gone\n",
                client.camera().c_str(), long{map.map_id()}, long{map.seq()},
                change.whole ? " (whole)" : "", map.keyframes().size(), map.landmarks().size(),
                change.removed_landmarks.size());
    std::fflush(stdout);
  });
  while (lcm.handleTimeout(50) >= 0) client.tick();
  return 1;
}
