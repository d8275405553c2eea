// An LCM event log, as lcm-logger writes it, read event by event. With a reader of its own:
// liblcm's writes to the terminal, does not tell a log that was cut from one that ends, and
// believes any length, with a crash from 2 GiB on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <memory>
#include <string>
#include <vector>

namespace eifmap {

class EventLog {
 public:
  explicit EventLog(const std::filesystem::path& file);
  // `in`: of `size` bytes, which can be sought in; `name`: for the problem.
  EventLog(std::unique_ptr<std::istream> in, std::int64_t size, std::string name);

  // Goes to the next event, the first one at first. False at the end, and where the log cannot be
  // read on: then problem() says why.
  bool next();

  const std::string& channel() const { return channel_; }
  // When the logger received it, us since the Unix epoch, by its clock.
  std::int64_t time_us() const { return time_us_; }
  // The message; to be asked for once, an event that is passed over is not read.
  std::vector<std::uint8_t> read_message();

  std::int64_t events() const { return events_; }  // so far
  // "" or what is wrong, with where the part that can be read ends.
  const std::string& problem() const { return problem_; }

 private:
  bool fail(const std::string& what);

  std::unique_ptr<std::istream> in_;
  std::string name_;
  std::int64_t size_ = 0, at_ = 0;  // bytes; at_: where the next event begins
  std::int64_t events_ = 0;
  std::string channel_;
  std::int64_t time_us_ = 0;
  std::int32_t message_size_ = 0;
  std::string problem_;
};

}  // namespace eifmap
