// A copy of the map that an eifmap server publishes: exactly that map, whatever the link loses,
// however late it begins. It notices what is missing and asks the server for it by itself.
//
//   lcm::LCM lcm(url);
//   eifmap::MapClient client(lcm, "front");
//   client.on_change([&](const eifmap::MapChange& change) { ... client.map() ... });
//   while (lcm.handleTimeout(50) >= 0) client.tick();
//
// Everything in the thread that handles the LCM object. Needs LCM and nothing else of eifmap.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "published/published_map.h"

namespace lcm {
class LCM;
}

namespace eifmap {

class MapClient {
 public:
  // To send requests by.
  using Send =
      std::function<void(const std::string& channel, const std::vector<std::uint8_t>& bytes)>;
  using OnChange = std::function<void(const MapChange& change)>;

  // Listens to the channels of a camera; "": of the first whose server is heard. The LCM object
  // must outlive the client. Throws std::invalid_argument where it is no name of a camera.
  MapClient(lcm::LCM& lcm, const std::string& camera);
  // Where messages come by another way: they are given to receive().
  MapClient(const std::string& camera, Send send);
  ~MapClient();
  MapClient(const MapClient&) = delete;
  MapClient& operator=(const MapClient&) = delete;

  // `on_change` is called within receive(); what it throws is lost.
  void on_change(OnChange on_change);

  // Any message of any channel; those of no concern are passed over.
  void receive(const std::string& channel, const void* data, std::size_t size);
  // To be called now and then, 10 times a second or more: asks for what is missing.
  void tick();

  const std::string& camera() const;  // "" while none has been heard
  // The map as of map().seq(); nothing else until the next update is whole.
  const PublishedMap& map() const;
  // Whether the server is known to be further than that, or nothing has arrived yet.
  bool is_stale() const;
  // Whether the server has been heard in the last 3 seconds.
  bool hears_server() const;

  struct Counts {
    std::int64_t updates = 0, whole_maps = 0;  // applied; of them whole ones
    std::int64_t parts = 0;                    // that came
    std::int64_t requests = 0;                 // made
    std::int64_t malformed = 0;                // messages that could not be read
    std::int64_t wrong_digests = 0;  // copies that were not the published map: never, so far
  };
  Counts counts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace eifmap
