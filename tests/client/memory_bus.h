// A memq:// network of real LCM that the test pumps by hand.
#pragma once

#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bus/lcm_bus.h"

namespace eifmap::test {

// Remembers every message in the order of its sending.
class Recorder {
 public:
  struct Message {
    std::string channel;
    std::vector<std::uint8_t> bytes;
  };

  Recorder() : lcm_(std::make_shared<lcm::LCM>("memq://")), bus_(lcm_), sender_(lcm_) {
    bus_.subscribe(".*", 0, [this](const std::string& channel, Bytes bytes) {
      messages_.push_back({channel, {bytes.begin(), bytes.end()}});
    });
  }

  Bus& sender() { return sender_; }

  // What was sent so far, handed out.
  const std::vector<Message>& messages() {
    for (std::size_t before = messages_.size() + 1; before != messages_.size();) {
      before = messages_.size();
      bus_.receive(std::chrono::milliseconds(20));
    }
    return messages_;
  }

 private:
  std::shared_ptr<lcm::LCM> lcm_;
  LcmBus bus_, sender_;
  std::vector<Message> messages_;
};

}  // namespace eifmap::test
