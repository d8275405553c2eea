#include "command/command_message.h"

#include <algorithm>
#include <array>

#include "wire/channel.h"
#include "wire/layout.h"
#include "wire/limits.h"

namespace eifmap {
namespace {

constexpr CommandText::Argument kNone{nullptr, false};

constexpr std::array kTexts{
    CommandText{command_t::CMD_PING, "ping", "is it there, and what does it map", {kNone, kNone}},
    CommandText{command_t::CMD_PAUSE, "pause", "map no frames until resume", {kNone, kNone}},
    CommandText{command_t::CMD_RESUME, "resume", "go on after pause", {kNone, kNone}},
    CommandText{
        command_t::CMD_RESET, "reset", "begin a new map; the old one is given up", {kNone, kNone}},
    CommandText{command_t::CMD_SAVE, "save", "save the map", {{"name", false}, kNone}},
    CommandText{command_t::CMD_LOAD, "load", "go on in a saved map", {{"name", true}, kNone}},
    CommandText{command_t::CMD_LOCALIZE_ONLY,
                "localize-only",
                "on: poses in the map, which stays as it is; off: map again",
                {{"mode", true}, kNone}},
    CommandText{command_t::CMD_MAP, "map", "which maps there are", {kNone, kNone}},
    CommandText{command_t::CMD_SNAPSHOT,
                "snapshot",
                "send the whole published map again, to all",
                {kNone, kNone}},
    CommandText{command_t::CMD_CHECKPOINT,
                "checkpoint",
                "save the map as it is now, to come back to by undo",
                {kNone, kNone}},
    CommandText{command_t::CMD_UNDO, "undo", "back to the last checkpoint", {kNone, kNone}},
    CommandText{command_t::CMD_SET_SCALE,
                "set-scale",
                "say how many metres a unit of the map is, and its relative sigma",
                {{"metres_per_unit", true}, {"sigma", false}}},
    CommandText{command_t::CMD_SHUTDOWN, "shutdown", "end the server", {kNone, kNone}},
};

constexpr std::array<std::string_view, 6> kResults{"OK",   "ACCEPTED",    "ERROR",
                                                   "BUSY", "UNSUPPORTED", "DENIED"};

void scan_pairs(LayoutScanner& in, const char* count, std::size_t most, std::size_t most_text) {
  const std::size_t n = in.count(count, most);
  for (std::size_t i = 0; i < n && in.ok(); ++i)
    for (const char* name : {"key", "value"}) in.string(name, most_text);
}

void scan_mac(LayoutScanner& in) {
  in.array("mac", in.count("mac_size", kMacBytes), 1);
}

void scan_command(LayoutScanner& in) {
  in.skip(5 * 8);  // utime to ticket
  in.string("camera", kMaxText);
  in.skip(2);  // command
  scan_pairs(in, "num_args", kMaxArguments, kMaxArgument);
  scan_mac(in);
}

void scan_reply(LayoutScanner& in) {
  in.skip(5 * 8);  // utime to ticket
  in.string("camera", kMaxText);
  in.skip(2 + 1 + 2);  // command, result, reason
  in.string("message", kMaxText);
  in.skip(3 * 8);  // map_id to map_seq
  scan_pairs(in, "num_values", kMaxValues, kMaxText);
  scan_mac(in);
}

// What both have.
template <class Message>
std::string problem_of_both(const Message& message) {
  if (!valid_camera_name(message.camera)) return "the camera's name is not 1 to 24 of A-Za-z0-9_-";
  if (!valid_time(message.utime)) return "utime is " + std::to_string(message.utime);
  if (message.sender == 0) return "sender is 0: the reply would be nobody's";
  if (message.request_id <= 0) return "request_id is " + std::to_string(message.request_id);
  if (message.server_epoch < 0) return "server_epoch is " + std::to_string(message.server_epoch);
  if (message.ticket < 0) return "ticket is " + std::to_string(message.ticket);
  if (message.mac_size != 0 && message.mac_size != static_cast<std::int32_t>(kMacBytes))
    return "mac_size is " + std::to_string(message.mac_size) + ", must be 0 or 32";
  return "";
}

std::string problem_of_command(const command_t& message) {
  const auto& args = message.args;
  for (auto one = args.begin(); one != args.end(); ++one)
    if (std::any_of(one + 1, args.end(),
                    [one](const diagnostic_t& other) { return other.key == one->key; }))
      return "argument " + one->key + " is given twice";
  return problem_of_both(message);
}

std::string problem_of_reply(const reply_t& message) {
  if (message.result < reply_t::RESULT_OK || message.result > reply_t::RESULT_DENIED)
    return "result is " + std::to_string(message.result);
  return problem_of_both(message);
}

}  // namespace

std::span<const CommandText> all_commands() {
  return kTexts;
}

const CommandText* command_text(std::int16_t command) {
  for (const CommandText& text : kTexts)
    if (text.command == command) return &text;
  return nullptr;
}

const CommandText* command_named(std::string_view name) {
  for (const CommandText& text : kTexts)
    if (text.name == name) return &text;
  return nullptr;
}

std::string_view result_name(std::int8_t result) {
  if (result < reply_t::RESULT_OK || result > reply_t::RESULT_DENIED) return "UNKNOWN";
  return kResults[static_cast<std::size_t>(result)];
}

std::string argument(const command_t& command, std::string_view key) {
  for (const diagnostic_t& entry : command.args)
    if (entry.key == key) return entry.value;
  return "";
}

std::string arguments_problem(const command_t& command, const CommandText& text) {
  const std::string name = text.name;
  for (const auto& [key, required] : text.arguments)
    if (key && required && argument(command, key).empty()) return name + " wants " + key;
  for (const diagnostic_t& entry : command.args)
    if (std::none_of(std::begin(text.arguments), std::end(text.arguments),
                     [&entry](const auto& known) { return known.key && entry.key == known.key; }))
      return name + " takes no " + entry.key;
  return "";
}

Decoded<command_t> decode_command(Bytes bytes) {
  return decode_checked<command_t>(bytes, scan_command, problem_of_command);
}

Decoded<reply_t> decode_reply(Bytes bytes) {
  return decode_checked<reply_t>(bytes, scan_reply, problem_of_reply);
}

}  // namespace eifmap
