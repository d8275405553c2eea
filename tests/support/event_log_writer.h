// Writes an LCM event log by liblcm's own writer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "wire/bytes.h"
#include "wire/channel.h"

namespace eifmap::test {

class EventLogWriter {
 public:
  explicit EventLogWriter(const std::filesystem::path& file) : out_(file.string(), "w") {}

  // 10 ms after the one before.
  void write(const std::string& channel, Bytes message) {
    std::vector<std::uint8_t> copy(message.begin(), message.end());
    lcm::LogEvent event;
    event.timestamp = time_us_ += 10'000;
    event.channel = channel;
    event.datalen = static_cast<std::int32_t>(copy.size());
    event.data = copy.data();
    if (out_.writeEvent(&event) != 0) throw std::runtime_error("the log cannot be written");
    std::fflush(out_.getFilePtr());
  }
  void write(const std::string& camera, ChannelKind kind, Bytes message) {
    write(channel_name(camera, kind), message);
  }

 private:
  lcm::LogFile out_;
  std::int64_t time_us_ = 1'700'000'000'000'000;
};

}  // namespace eifmap::test
