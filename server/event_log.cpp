#include "server/event_log.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

namespace eifmap {
namespace {

// Of each event, big-endian: the mark, the event's number, its time, and the lengths of what
// follows.
constexpr std::uint32_t kMark = 0xeda1da01;
constexpr std::size_t kHeaderSize = 4 + 8 + 8 + 4 + 4;
constexpr std::int32_t kMaxChannel = 63;  // as LCM has it

std::uint64_t number_at(const std::array<unsigned char, kHeaderSize>& header, std::size_t first,
                        std::size_t size) {
  std::uint64_t number = 0;
  for (std::size_t i = first; i < first + size; ++i) number = number << 8 | header[i];
  return number;
}

}  // namespace

EventLog::EventLog(const std::filesystem::path& file) : name_(file.string()) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  auto in = std::make_unique<std::ifstream>(file, std::ios::binary);
  if (error || !*in) {
    problem_ = name_ + ": cannot be read: " + (error ? error.message() : std::strerror(errno)) +
               "; give a log that lcm-logger wrote";
    return;
  }
  in_ = std::move(in);
  size_ = static_cast<std::int64_t>(size);
}

EventLog::EventLog(std::unique_ptr<std::istream> in, std::int64_t size, std::string name)
    : in_(std::move(in)), name_(std::move(name)), size_(size) {}

bool EventLog::fail(const std::string& what) {
  problem_ = name_ + ": " + what + " at byte " + std::to_string(at_) + " of " +
             std::to_string(size_) + ", after " + std::to_string(events_) + " events; ";
  problem_ +=
      events_ > 0 ? "only what comes before it is used" : "give a log that lcm-logger wrote";
  return false;
}

bool EventLog::next() {
  if (!problem_.empty() || at_ == size_) return false;
  if (size_ - at_ < static_cast<std::int64_t>(kHeaderSize)) return fail("is cut off");
  std::array<unsigned char, kHeaderSize> header{};
  in_->seekg(at_);
  if (!in_->read(reinterpret_cast<char*>(header.data()), header.size()))
    return fail("cannot be read");
  if (number_at(header, 0, 4) != kMark)
    return fail(events_ > 0 ? "is corrupt" : "is no LCM event log");
  time_us_ = static_cast<std::int64_t>(number_at(header, 12, 8));
  const auto channel_size = static_cast<std::int32_t>(number_at(header, 20, 4));
  message_size_ = static_cast<std::int32_t>(number_at(header, 24, 4));
  if (channel_size < 1 || channel_size > kMaxChannel || message_size_ < 0)
    return fail("is corrupt");
  const std::int64_t end =
      at_ + static_cast<std::int64_t>(kHeaderSize) + channel_size + message_size_;
  if (end > size_) return fail("is cut off");
  channel_.resize(static_cast<std::size_t>(channel_size));
  if (!in_->read(channel_.data(), channel_size)) return fail("cannot be read");
  at_ = end;
  ++events_;
  return true;
}

std::vector<std::uint8_t> EventLog::read_message() {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message_size_));
  if (!in_->read(reinterpret_cast<char*>(bytes.data()), message_size_)) {
    fail("cannot be read");
    bytes.clear();
  }
  return bytes;
}

}  // namespace eifmap
