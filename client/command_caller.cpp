#include "client/command_caller.h"

#include <algorithm>
#include <utility>

#include "published/map_request.h"
#include "wire/clock.h"

namespace eifmap {

CommandCaller::CommandCaller(Order order, const Secret* secret, std::chrono::milliseconds timeout,
                             TimePoint now)
    : order_(std::move(order)), secret_(secret), end_(now + timeout) {
  require_camera_name(order_.camera);
  command_.sender = random_requester();
  command_.request_id = 0;
  prepare(command_t::CMD_PING, {}, 0, 0, now);
}

void CommandCaller::prepare(std::int16_t command, std::vector<diagnostic_t> args,
                            std::int64_t server_epoch, std::int64_t ticket, TimePoint now) {
  command_.utime = now_us();
  ++command_.request_id;
  command_.server_epoch = server_epoch;
  command_.ticket = ticket;
  command_.camera = order_.camera;
  command_.command = command;
  command_.args = std::move(args);
  command_.num_args = static_cast<std::int32_t>(command_.args.size());
  command_.mac.clear();
  command_.mac_size = 0;
  if (secret_) sign(command_, *secret_);
  bytes_ = encode(command_);
  next_send_ = now;
  pause_ = kFirstPause;
}

CommandCaller::TimePoint CommandCaller::tick(TimePoint now, const Send& send) {
  if (state_ == State::kPinging && reply_ && now >= settled_) go_on(now);
  if (!is_over() && now >= end_) give_up();
  if (is_over()) return now;
  const bool waits_for_others = state_ == State::kPinging && reply_;
  if (!waits_for_others && now >= next_send_) {
    send(channel_name(order_.camera, ChannelKind::kCommand), bytes_);
    ++sent_;
    next_send_ = now + pause_;
    pause_ = std::min(pause_ * 3 / 2, kLongestPause);
  }
  return std::min(end_, waits_for_others ? settled_ : next_send_);
}

void CommandCaller::give_up() {
  if (state_ == State::kPinging) {
    state_ = State::kNoReply;
  } else if (of_other_run_) {
    reply_ = std::move(of_other_run_);
    state_ = State::kAnswered;
  } else {
    state_ = State::kNoAnswer;
  }
}

bool CommandCaller::is_trusted(const reply_t& reply) const {
  return !secret_ || is_signed_by(reply, *secret_);
}

void CommandCaller::take(Bytes bytes, TimePoint now) {
  if (is_over()) return;
  Decoded<reply_t> decoded = decode_reply(bytes);
  if (!decoded.ok() || decoded.value.camera != order_.camera ||
      decoded.value.sender != command_.sender || decoded.value.request_id != command_.request_id)
    return;
  reply_t& reply = decoded.value;
  // Who has another secret cannot sign its refusal with this one. While nothing has been commanded
  // yet, to believe it costs no more than the command.
  const bool is_refusal = state_ == State::kPinging && reply.result == reply_t::RESULT_DENIED;
  if (!is_trusted(reply) && !is_refusal) {
    ++untrusted_;
    return;
  }
  if (state_ == State::kPinging) return take_of_ping(std::move(reply), now);
  if (reply.server_epoch != command_.server_epoch) {
    of_other_run_ = std::move(reply);
    return;
  }
  reply_ = std::move(reply);
  state_ = State::kAnswered;
}

void CommandCaller::take_of_ping(reply_t reply, TimePoint now) {
  const bool is_first = !reply_;
  if (is_first) settled_ = now + kOthers;
  const auto refuses = [](const reply_t& r) { return r.result == reply_t::RESULT_DENIED; };
  if (is_first || refuses(*reply_)) {
    reply_ = std::move(reply);
  } else if (!refuses(reply) && reply.server_epoch != reply_->server_epoch) {
    state_ = State::kSeveral;
  }
}

// After the ping.
void CommandCaller::go_on(TimePoint now) {
  if (order_.command == command_t::CMD_PING || reply_->result != reply_t::RESULT_OK) {
    state_ = State::kAnswered;
    return;
  }
  state_ = State::kCommanding;
  prepare(order_.command, order_.args, reply_->server_epoch, reply_->ticket, now);
  reply_.reset();
}

}  // namespace eifmap
