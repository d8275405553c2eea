// What an event log holds, before any of it is mapped: whose frames, and what which run of a server
// decided on them. A decision comes after its frame, so that a log is read twice.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "convert/decision_message.h"
#include "decision.h"
#include "server/event_log.h"
#include "wire/channel.h"

namespace eifmap {

struct FrameName {
  std::int64_t time_us = 0, publisher = 0, seq = -1;
  auto operator<=>(const FrameName&) const = default;
};
inline FrameName name_of(const Decision& decision) {
  return {decision.time_us, decision.publisher, decision.seq};
}
std::string in_words(const FrameName& name);

struct LogContents {
  struct Run {
    std::vector<Decision> decisions;  // as they were made
    std::set<FrameName> posed;        // frames that a pose was published of
  };
  struct Camera {
    std::int64_t frames = 0;  // of parts the first ones
    // Messages as they came, each once.
    std::map<MeasurementId, std::vector<std::uint8_t>> measurements;
    std::map<std::int64_t, Run> runs;  // by server_epoch
  };
  std::map<std::string, Camera> cameras;
  std::int64_t unreadable = 0;  // messages on channels of decisions, poses and measurements
  std::string problem;          // EventLog::problem()

  // Of each server_epoch, the number of decisions on all cameras.
  std::map<std::int64_t, std::int64_t> epochs() const;
};

// `image_channel`: one more, whose images are `camera`'s; "" none.
LogContents read_contents(EventLog log, const std::string& image_channel,
                          const std::string& camera);

// Whose message the event is, and which; nothing where it is none of ours.
std::optional<Channel> channel_of(const EventLog& log, const std::string& image_channel,
                                  const std::string& camera);

}  // namespace eifmap
