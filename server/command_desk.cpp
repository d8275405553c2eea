#include "server/command_desk.h"

#include <cmath>
#include <random>

#include "sequence/number_text.h"
#include "wire/channel.h"
#include "wire/clock.h"
#include "wire/limits.h"

namespace eifmap {
namespace {

constexpr double kDefaultSigma = 0.001;  // relative, of a scale that is said
constexpr double kMostSigma = 0.1, kLeastScale = 1e-6, kMostScale = 1e6;

CommandOutcome deny(Reason reason, std::string detail = "") {
  return CommandOutcome::refuse(reason, std::move(detail), reply_t::RESULT_DENIED);
}

CommandOutcome bad_arguments(std::string detail) {
  return CommandOutcome::refuse(Reason::kBadArguments, std::move(detail));
}

CommandOutcome set_scale(const command_t& command, CommandTarget& target) {
  const std::string scale_text = argument(command, "metres_per_unit");
  const std::string sigma_text = argument(command, "sigma");
  const std::optional<double> scale = parse_number(scale_text);
  const std::optional<double> sigma = sigma_text.empty() ? kDefaultSigma : parse_number(sigma_text);
  if (!scale || !(*scale >= kLeastScale && *scale <= kMostScale))
    return bad_arguments("metres_per_unit is '" + scale_text + "', wanted 1e-6 to 1e6");
  if (!sigma || !(*sigma > 0 && *sigma <= kMostSigma))
    return bad_arguments("sigma is '" + sigma_text + "', wanted above 0 to 0.1, of the scale");
  return target.set_scale(*scale, *sigma);
}

CommandOutcome localize_only(const command_t& command, CommandTarget& target) {
  const std::string mode = argument(command, "mode");
  if (mode != "on" && mode != "off")
    return bad_arguments("mode is '" + mode + "', wanted on or off");
  return target.localize_only(mode == "on");
}

std::string in_words(const CommandOutcome& outcome) {
  if (outcome.reason == Reason::kNone) return outcome.message;
  const std::string text = describe(outcome.reason).text;
  return outcome.message.empty() ? text : text + ": " + outcome.message;
}

CommandOutcome not_stored(const char* what) {
  return CommandOutcome::refuse(
      Reason::kUnsupported, std::string(what) + " needs maps that are stored, which it does not do",
      reply_t::RESULT_UNSUPPORTED);
}

}  // namespace

CommandOutcome CommandTarget::save(const std::string&) {
  return not_stored("save");
}
CommandOutcome CommandTarget::load(const std::string&) {
  return not_stored("load");
}
CommandOutcome CommandTarget::checkpoint() {
  return not_stored("checkpoint");
}
CommandOutcome CommandTarget::undo() {
  return not_stored("undo");
}
CommandOutcome CommandTarget::localize_only(bool) {
  return not_stored("localize-only");
}

std::int64_t random_ticket() {
  std::random_device device;
  const std::uint64_t bits = std::uint64_t{device()} << 32 | device();
  return static_cast<std::int64_t>(bits >> 2) + 1;
}

CommandDesk::CommandDesk(std::string camera, CommandAccess access, CommandTarget& target)
    : camera_(std::move(camera)), access_(std::move(access)), target_(target) {
  require_camera_name(camera_);
}

std::optional<std::vector<std::uint8_t>> CommandDesk::answer(Bytes bytes, TimePoint now) {
  Decoded<command_t> decoded = decode_command(bytes);
  if (decoded.ok()) decoded.detail = camera_problem(decoded.value.camera, camera_);
  if (!decoded.detail.empty()) {
    ++counts_.refused[Reason::kMalformedMessage];
    return std::nullopt;
  }
  const command_t& command = decoded.value;
  bool is_signed = false;
  if (std::optional<CommandOutcome> refusal = denied(command, is_signed)) {
    ++counts_.refused[refusal->reason];
    return reply_to(command, std::move(*refusal), is_signed, now);
  }
  if (command.command == command_t::CMD_PING) {
    ++counts_.pings;
    return reply_to(command, do_once(command), is_signed, now);
  }
  const RequestMemory::Request request{command.sender, command.request_id, command.ticket};
  if (const std::vector<std::uint8_t>* const reply = memory_.reply_to(request)) {
    ++counts_.repeated;
    return *reply;
  }
  if (std::string problem = age_problem(command, now); !problem.empty()) {
    ++counts_.refused[Reason::kTooOld];
    return reply_to(command, deny(Reason::kTooOld, std::move(problem)), is_signed, now);
  }
  CommandOutcome outcome = do_once(command);
  ++counts_.done;
  if (outcome.reason != Reason::kNone) ++counts_.refused[outcome.reason];
  const CommandText* const text = command_text(command.command);
  counts_.last =
      (text ? text->name : std::to_string(command.command)) + std::string(": ") + in_words(outcome);
  std::vector<std::uint8_t> reply = reply_to(command, std::move(outcome), is_signed, now);
  memory_.keep(request, reply);
  return reply;
}

// Who commands, and which run of the server: before anything else is looked at.
std::optional<CommandOutcome> CommandDesk::denied(const command_t& command, bool& is_signed) const {
  if (!access_.secret && !access_.is_local) return deny(Reason::kSecretWanted);
  if (access_.secret) {
    if (command.mac_size == 0) return deny(Reason::kNotSigned);
    is_signed = is_signed_by(command, *access_.secret);
    if (!is_signed) return deny(Reason::kBadSignature);
  }
  const bool is_ping = command.command == command_t::CMD_PING;
  if (command.server_epoch == access_.server_epoch || (is_ping && command.server_epoch == 0))
    return std::nullopt;
  if (command.server_epoch == 0) return deny(Reason::kOtherRun, "it names none; ping first");
  return deny(Reason::kOtherRun, "it names " + std::to_string(command.server_epoch) + ", this is " +
                                     std::to_string(access_.server_epoch));
}

std::string CommandDesk::age_problem(const command_t& command, TimePoint now) const {
  const std::int64_t latest = access_.ticket(now);
  constexpr std::int64_t kHolds = std::chrono::microseconds(kTicketHolds).count();
  if (command.ticket < access_.first_ticket || command.ticket > latest)
    return "its ticket is none of this run's";
  if (latest - command.ticket > kHolds) return "its ticket is older than 60 s; ping again";
  return memory_.problem({command.sender, command.request_id, command.ticket});
}

CommandOutcome CommandDesk::do_once(const command_t& command) {
  try {
    return dispatch(command);
  } catch (const std::exception& error) {
    return CommandOutcome::refuse(Reason::kInternalError, error.what());
  }
}

CommandOutcome CommandDesk::dispatch(const command_t& command) {
  const CommandText* const text = command_text(command.command);
  if (!text)
    return CommandOutcome::refuse(Reason::kUnknownCommand,
                                  "its code is " + std::to_string(command.command),
                                  reply_t::RESULT_UNSUPPORTED);
  if (std::string problem = arguments_problem(command, *text); !problem.empty())
    return bad_arguments(std::move(problem));
  switch (command.command) {
    case command_t::CMD_PAUSE:
      return target_.pause();
    case command_t::CMD_RESUME:
      return target_.resume();
    case command_t::CMD_RESET:
      return target_.reset();
    case command_t::CMD_SAVE:
      return target_.save(argument(command, "name"));
    case command_t::CMD_LOAD:
      return target_.load(argument(command, "name"));
    case command_t::CMD_LOCALIZE_ONLY:
      return localize_only(command, target_);
    case command_t::CMD_MAP:
      return target_.maps();
    case command_t::CMD_SNAPSHOT:
      return target_.snapshot();
    case command_t::CMD_CHECKPOINT:
      return target_.checkpoint();
    case command_t::CMD_UNDO:
      return target_.undo();
    case command_t::CMD_SET_SCALE:
      return set_scale(command, target_);
    case command_t::CMD_SHUTDOWN:
      return target_.shutdown();
    default:
      return target_.ping();
  }
}

// Signed for those alone who have signed: else anybody could have a refusal signed, and show it to
// somebody who commands.
std::vector<std::uint8_t> CommandDesk::reply_to(const command_t& command, CommandOutcome outcome,
                                                bool is_signed, TimePoint now) {
  reply_t reply;
  reply.utime = now_us();
  reply.sender = command.sender;
  reply.request_id = command.request_id;
  reply.server_epoch = access_.server_epoch;
  reply.ticket = access_.ticket(now);
  reply.camera = camera_;
  reply.command = command.command;
  reply.result = outcome.result;
  reply.reason = static_cast<std::int16_t>(outcome.reason);
  reply.message = clipped(in_words(outcome));
  const CommandTarget::Place place = target_.place();
  reply.map_id = place.map_id;
  reply.map_epoch = place.map_epoch;
  reply.map_seq = place.map_seq;
  for (auto& [key, value] : outcome.values) {
    if (reply.values.size() == kMaxValues) break;
    reply.values.emplace_back();
    reply.values.back().key = clipped(std::move(key));
    reply.values.back().value = clipped(std::move(value));
  }
  reply.num_values = static_cast<std::int32_t>(reply.values.size());
  reply.mac_size = 0;
  if (is_signed && access_.secret) sign(reply, *access_.secret);
  return encode(reply);
}

}  // namespace eifmap
