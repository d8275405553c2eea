#include <spdlog/spdlog.h>

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "bus/lcm_bus.h"
#include "client/command_caller.h"
#include "client/commands.h"
#include "program/command_line.h"
#include "reason.h"

namespace eifmap {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string command, camera{kNoCamera}, lcm_url = kDefaultLcmUrl, secret_file;
  std::vector<std::string> arguments;
  double timeout_s = 5;
  bool json = false;
};

// Replies may wait while the process does not run.
constexpr int kQueue = 100;

// Of the network: nothing that a terminal would obey.
std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return (c >= 0 && c < ' ') || c == 0x7f; }, '?');
  return text;
}

std::string usage_of(const CommandText& text) {
  std::string usage = text.name;
  for (const auto& [key, required] : text.arguments)
    if (key) usage += required ? std::string(" ") + key : std::string(" [") + key + "]";
  return usage;
}

std::string list_of_commands() {
  std::string list = "Commands:\n";
  for (const CommandText& text : all_commands()) {
    std::string usage = usage_of(text);
    usage.resize(std::max(usage.size() + 1, std::size_t{36}), ' ');
    list += "  " + usage + text.what + "\n";
  }
  return list + "Exit code: 0 done, 1 refused, failed or unanswered, 2 a mistake on this line.";
}

// What was typed after the command, by the names that the command has for it.
std::vector<diagnostic_t> named_arguments(const CommandText& text,
                                          const std::vector<std::string>& given) {
  std::vector<diagnostic_t> args;
  for (const auto& [key, required] : text.arguments) {
    if (!key) break;
    if (args.size() == given.size()) {
      if (required) throw std::invalid_argument(usage_of(text) + ": " + key + " is missing");
      break;
    }
    diagnostic_t entry;
    entry.key = key;
    entry.value = given[args.size()];
    if (entry.value.empty() || entry.value.size() > kMaxArgument)
      throw std::invalid_argument(usage_of(text) + ": " + key + " must be 1 to " +
                                  std::to_string(kMaxArgument) + " characters");
    args.push_back(entry);
  }
  if (args.size() < given.size())
    throw std::invalid_argument("'" + given[args.size()] + "' is too much: " + usage_of(text) +
                                " is all that it takes");
  return args;
}

Json json_of(const reply_t& reply) {
  const CommandText* const text = command_text(reply.command);
  Json json = {{"command", text ? text->name : std::to_string(reply.command)},
               {"camera", reply.camera},
               {"result", result_name(reply.result)},
               {"reason", describe(static_cast<Reason>(reply.reason)).name},
               {"message", reply.message},
               {"server_epoch", reply.server_epoch},
               {"map_id", reply.map_id},
               {"map_epoch", reply.map_epoch},
               {"map_seq", reply.map_seq},
               {"values", Json::object()}};
  for (const diagnostic_t& value : reply.values) json["values"][value.key] = value.value;
  return json;
}

bool is_done(const reply_t& reply) {
  return reply.result == reply_t::RESULT_OK || reply.result == reply_t::RESULT_ACCEPTED;
}

int tell(const reply_t& reply, bool as_json) {
  const ReasonText& reason = describe(static_cast<Reason>(reply.reason));
  if (as_json) {
    std::cout << json_of(reply).dump(1, ' ', false, Json::error_handler_t::replace) << '\n';
  } else {
    std::cout << result_name(reply.result)
              << (reply.reason == 0 ? "" : std::string(" ") + reason.name) << ": "
              << printable(reply.message) << '\n';
    for (const diagnostic_t& value : reply.values)
      std::cout << "  " << printable(value.key) << ' ' << printable(value.value) << '\n';
  }
  if (is_done(reply)) return 0;
  std::cout << std::flush;
  spdlog::error("{}{}{}", reply.result == reply_t::RESULT_ERROR ? "failed" : "refused",
                *reason.hint ? "; " : "", reason.hint);
  return kFailed;
}

std::string problem_of(const CommandCaller& caller, const Options& options) {
  const std::string untrusted =
      caller.untrusted() > 0
          ? "; replies came, but not signed with the secret of " + options.secret_file
          : "";
  switch (caller.state()) {
    case CommandCaller::State::kNoReply:
      return fmt::format("no reply in {} s: is a server running at {}{}?", options.timeout_s,
                         options.lcm_url,
                         options.camera == kNoCamera ? "" : ", and mapping " + options.camera) +
             untrusted;
    case CommandCaller::State::kNoAnswer:
      return fmt::format(
                 "the server at {} answered a ping, but not the command, in {} s: it may have "
                 "been done",
                 options.lcm_url, options.timeout_s) +
             untrusted;
    default:
      return "several servers answer at " + options.lcm_url +
             ", and nothing was done: name the camera of one by --camera";
  }
}

// Nothing when a signal came.
std::optional<CommandCaller::State> call(CommandCaller& caller, Bus& bus, StopSignals& signals) {
  bus.subscribe(literal_pattern(caller.reply_channel()), kQueue,
                [&caller](const std::string&, Bytes bytes) { caller.take(bytes, Clock::now()); });
  while (!caller.is_over() && !signals.arrived()) {
    const auto next = caller.tick(
        Clock::now(), [&bus](const std::string& channel, const std::vector<std::uint8_t>& bytes) {
          bus.publish(channel, bytes);
        });
    const auto wait = std::chrono::ceil<std::chrono::milliseconds>(next - Clock::now());
    if (caller.is_over()) break;
    if (!bus.receive(std::clamp(wait, std::chrono::milliseconds(1), std::chrono::milliseconds(50))))
      throw std::runtime_error("LCM broke off");
  }
  bus.unsubscribe_all();
  if (!caller.is_over()) return std::nullopt;
  return caller.state();
}

int run(const Options& options, StopSignals& signals) {
  CommandCaller::Order order;
  std::optional<Secret> secret;
  try {
    if (!valid_camera_name(options.camera))
      throw std::invalid_argument("camera is '" + options.camera +
                                  "', wanted 1 to 24 characters of A-Z a-z 0-9 _ -");
    const CommandText& text = *command_named(options.command);
    order = {options.camera, text.command, named_arguments(text, options.arguments)};
    if (!options.secret_file.empty()) {
      SecretFile read = read_secret(options.secret_file);
      if (!read.secret) throw std::invalid_argument(read.problem);
      secret.emplace(std::move(*read.secret));
    }
  } catch (const std::invalid_argument& error) {
    spdlog::error(error.what());
    return kBadOptions;
  }
  const LcmBus::Opened opened = LcmBus::open(options.lcm_url);
  if (!opened.bus) {
    spdlog::error(opened.problem);
    return kFailed;
  }
  CommandCaller caller(
      order, secret ? &*secret : nullptr,
      std::chrono::milliseconds(static_cast<std::int64_t>(1000 * options.timeout_s)), Clock::now());
  const auto state = call(caller, *opened.bus, signals);
  if (state == CommandCaller::State::kAnswered) return tell(caller.reply(), options.json);
  spdlog::error(state ? problem_of(caller, options) : "interrupted before the reply came");
  return kFailed;
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const CommandText& text : all_commands()) all.emplace_back(text.name);
  return all;
}

}  // namespace

Command add_ctl_command(CLI::App& app) {
  auto* command = app.add_subcommand("ctl", "command a running server, and print its reply");
  const auto options = std::make_shared<Options>();
  command->add_option("command", options->command, "what to do, see below")
      ->required()
      ->check(one_of(names()));
  command->add_option("arguments", options->arguments, "of the command");
  command->add_option("--camera", options->camera, "default: all that the server maps");
  command->add_option("--secret-file", options->secret_file,
                      "the server's secret, with which the command is signed");
  command->add_option("--timeout", options->timeout_s, "s to wait for the reply")
      ->check(number_in(0.1, 3600));
  command->add_flag("--json", options->json, "print the reply as one JSON object");
  command->add_option("--lcm-url", options->lcm_url, "network that the server is on");
  command->footer(list_of_commands());
  return [command, options](StopSignals& signals) {
    return command->parsed() ? run(*options, signals) : -1;
  };
}

}  // namespace eifmap
