#include <spdlog/spdlog.h>

#include "bus/lcm_bus.h"
#include "client/commands.h"
#include "client/logger.h"
#include "program/command_line.h"

namespace eifmap {
namespace {

using std::chrono::milliseconds;

struct Options {
  std::string folder, camera, lcm_url = kDefaultLcmUrl;
  double until_silent_s = 0;
};

// What the server sent just before it stopped may still be on its way.
constexpr milliseconds kLastWords(300);

bool is_over(const Logger& logger, const Options& options) {
  const auto silence = Logger::Clock::now() - logger.last_message();
  if (logger.server_stopped()) return silence > kLastWords;
  return options.until_silent_s > 0 && logger.counts().poses > 0 &&
         silence > std::chrono::duration<double>(options.until_silent_s);
}

int run(const Options& options, StopSignals& signals) {
  const LcmBus::Opened bus = LcmBus::open(options.lcm_url);
  if (!bus.bus) {
    spdlog::error(bus.problem);
    return kFailed;
  }
  if (!bus.advice.empty()) spdlog::warn(bus.advice);
  const Logger::Opened opened = Logger::open(options.folder, options.camera, *bus.bus);
  if (!opened.logger) {
    spdlog::error(opened.problem);
    return kBadOptions;
  }
  Logger& logger = *opened.logger;
  spdlog::info("logging {} into {}", options.lcm_url, options.folder);
  bool healthy = true, chosen = !options.camera.empty();
  while (healthy && !signals.arrived() && !is_over(logger, options)) {
    healthy = bus.bus->receive(milliseconds(50));
    logger.tick();
    if (!chosen && !logger.camera().empty()) {
      spdlog::info("camera {} is logged, the first that was heard of; --camera names another",
                   logger.camera());
      chosen = true;
    }
  }
  if (!healthy) spdlog::error("LCM broke off at {}", options.lcm_url);
  const std::string problem = logger.finish();
  if (!problem.empty()) spdlog::error(problem);
  const Logger::Counts counts = logger.counts();
  spdlog::info("{} poses, {} of them tracked; map of {} keyframes and {} landmarks", counts.poses,
               counts.tracked, logger.map().map().keyframes().size(),
               logger.map().map().landmarks().size());
  if (counts.poses > 0 && logger.map().is_stale())
    spdlog::warn("the last updates of the map did not arrive: it is the one of update {}",
                 logger.map().map().seq());
  if (counts.malformed > 0) spdlog::warn("{} messages could not be read", counts.malformed);
  return healthy && problem.empty() ? 0 : kFailed;
}

}  // namespace

Command add_log_command(CLI::App& app) {
  auto* command = app.add_subcommand(
      "log", "write a server's poses and map to files, until it stops or a signal comes");
  const auto options = std::make_shared<Options>();
  command->add_option("folder", options->folder, "for trajectory.tum, poses.jsonl, ..., map.ply")
      ->required();
  command->add_option("--camera", options->camera, "default: the first that is heard of");
  command
      ->add_option("--until-silent", options->until_silent_s,
                   "stop when, after the first pose, nothing was heard for so many seconds")
      ->check(number_in(0));
  command->add_option("--lcm-url", options->lcm_url, "network to listen on");
  return [command, options](StopSignals& signals) {
    return command->parsed() ? run(*options, signals) : -1;
  };
}

}  // namespace eifmap
