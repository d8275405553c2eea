// A command on its way to a server and back, over a link that loses: a ping, which tells what the
// command must name, and then the command, each sent again until its reply comes. Knows no network
// and no clock.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "command/command_message.h"
#include "command/secret.h"
#include "wire/bytes.h"
#include "wire/channel.h"

namespace eifmap {

class CommandCaller {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  using Send = std::function<void(const std::string& channel, const std::vector<std::uint8_t>&)>;

  struct Order {
    std::string camera{kNoCamera};  // or the server as a whole
    std::int16_t command = command_t::CMD_PING;
    std::vector<diagnostic_t> args;
  };

  // `secret`: null none; must outlive the caller. Throws std::invalid_argument where the camera's
  // name is none.
  CommandCaller(Order order, const Secret* secret, std::chrono::milliseconds timeout,
                TimePoint now);

  // Sends what is due. Returns when to call again.
  TimePoint tick(TimePoint now, const Send& send);

  // A message of the channel reply_channel(). What is not of this caller, or not to be trusted, is
  // passed over.
  void take(Bytes bytes, TimePoint now);
  std::string reply_channel() const { return channel_name(order_.camera, ChannelKind::kReply); }

  enum class State {
    kPinging,
    kCommanding,
    kAnswered,  // reply()
    kNoReply,   // not even to the ping: nothing was done
    kNoAnswer,  // to the ping, but not to the command: it may have been done
    kSeveral,   // servers answered the ping, of which none is meant more than the others
  };
  State state() const { return state_; }
  bool is_over() const { return state_ != State::kPinging && state_ != State::kCommanding; }

  const reply_t& reply() const { return *reply_; }
  // Replies to it that were not signed by the secret.
  int untrusted() const { return untrusted_; }
  int sent() const { return sent_; }

  // First and longest pause before it is sent again, and how long others may answer the ping, too.
  static constexpr std::chrono::milliseconds kFirstPause{100}, kLongestPause{1000}, kOthers{100};

 private:
  void prepare(std::int16_t command, std::vector<diagnostic_t> args, std::int64_t server_epoch,
               std::int64_t ticket, TimePoint now);
  bool is_trusted(const reply_t& reply) const;
  void take_of_ping(reply_t reply, TimePoint now);
  void go_on(TimePoint now);
  void give_up();

  const Order order_;
  const Secret* const secret_;
  const TimePoint end_;
  State state_ = State::kPinging;
  command_t command_;                // in hand
  std::vector<std::uint8_t> bytes_;  // of it
  TimePoint next_send_;
  std::chrono::milliseconds pause_{0};
  std::optional<reply_t> reply_;
  std::optional<reply_t> of_other_run_;  // refused it: the server of a new run, or another one
  TimePoint settled_;                    // when no other server answers the ping any more
  int untrusted_ = 0, sent_ = 0;
};

}  // namespace eifmap
