// eifmap-server: options in, exit code out.
#include <malloc.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <iostream>
#include <opencv2/core/utility.hpp>

#include "bus/lcm_bus.h"
#include "bus/stop_signals.h"
#include "program/command_line.h"
#include "program/progress_bar.h"
#include "server/check_map.h"
#include "server/log_run.h"
#include "server/mapping_server.h"
#include "server/metrics_server.h"
#include "server/metrics_text.h"
#include "server/program_options.h"
#include "server/run_record.h"
#include "server/sequence_run.h"

namespace {

using namespace eifmap;

constexpr int kFailed = 1;
constexpr int kBadOptions = 2;

int run_recorded(SequenceRunOptions options, const ServerConfig& config, StopSignals& signals) {
  if (options.output.empty())
    throw std::invalid_argument(
        "--sequence needs --output FOLDER, for trajectories, map and report");
  options.features = config.features;
  options.mapper = config.mapper;
  options.handover = config.recorded_handover();
  ProgressBar bar(std::cerr, isatty(STDERR_FILENO) != 0);
  bool interrupted = false;
  const auto progress = [&](int done, int total) {
    bar.show(done, total);
    interrupted = interrupted || (done != total && signals.arrived());
    return !interrupted;
  };
  const std::string problem =
      run_sequence(options, progress, [](const std::string& note) { spdlog::warn(note); });
  if (!problem.empty()) {
    spdlog::error(problem);
    return kFailed;
  }
  if (interrupted)
    spdlog::warn("interrupted: the results in {} are partial", options.output.string());
  else
    spdlog::info("results are in {}", options.output.string());
  return 0;
}

int run_logged(LogRunOptions options, const std::filesystem::path& output,
               const ServerConfig& config, StopSignals& signals) {
  if (output.empty())
    throw std::invalid_argument("--log needs --output FOLDER, for trajectories, map and report");
  options.output = output;
  options.config = config;
  ProgressBar bar(std::cerr, isatty(STDERR_FILENO) != 0);
  bool interrupted = false;
  const auto progress = [&](int done, int total) {
    bar.show(done, total);
    interrupted = interrupted || (done != total && signals.arrived());
    return !interrupted;
  };
  const LogRunResult result =
      run_log(options, progress, [](const std::string& note) { spdlog::warn(note); });
  if (!result.problem.empty()) {
    spdlog::error(result.problem);
    return kFailed;
  }
  if (interrupted)
    spdlog::warn("interrupted: the results in {} are partial", output.string());
  else
    spdlog::info("{}; results are in {}", result.summary, output.string());
  return 0;
}

void log_change(const status_t& status) {
  const auto level = status.level == status_t::LEVEL_OK        ? spdlog::level::info
                     : status.level == status_t::LEVEL_WARNING ? spdlog::level::warn
                                                               : spdlog::level::err;
  static constexpr const char* kStates[] = {"waiting", "starting", "tracking",
                                            "lost",    "paused",   "stopping"};
  spdlog::log(level, "{}{}{}: {}{}{}", status.camera, status.camera.empty() ? "" : ": ",
              kStates[status.state], status.message, status.hint.empty() ? "" : "; ", status.hint);
}

// Neither server nor problem where none is wanted.
MetricsServer::Opened open_metrics(const ServerConfig& config, MappingServer& server) {
  if (config.metrics_port == 0) return {};
  auto opened = MetricsServer::open(config.metrics_at(),
                                    [&server] { return metrics_text(server.statuses()); });
  if (!opened.server) return opened;
  spdlog::info("metrics at {}", opened.server->url());
  if (!config.metrics_at().loopback())
    spdlog::warn("whoever reaches {} can read the metrics", config.metrics_address);
  return opened;
}

// What long-lived maps allocate lies scattered among what frames have freed, and the allocator
// keeps it all: every few seconds what is free goes back to the system. Large blocks, as of a map's
// file that is written anew, do so at once. Left to itself the allocator raises the threshold when
// it has seen some, takes the next from where it takes the others, and keeps as much as they were
// at the end of each thread's memory, where it cannot be trimmed. And all threads take from one
// place: what one frees another uses, where each would keep holes of its own. To be made before
// there are any.
class FreeMemory {
 public:
  FreeMemory() {
    constexpr int kLarge = 1 << 20;
    mallopt(M_MMAP_THRESHOLD, kLarge);
    mallopt(M_ARENA_MAX, 1);
  }
  void give_back_sometimes() {
    constexpr auto kPeriod = std::chrono::seconds(3);
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + kPeriod;
    malloc_trim(0);
  }

 private:
  std::chrono::steady_clock::time_point next_;
};

int run_live(const ServerConfig& config, const std::filesystem::path& output,
             StopSignals& signals) {
  if (!output.empty())
    if (const std::string problem = output_problem(output); !problem.empty()) {
      spdlog::error(problem);
      return kFailed;
    }
  FreeMemory memory;
  const LcmBus::Opened opened = LcmBus::open(config.lcm_url);
  if (!opened.problem.empty()) {
    spdlog::error(opened.problem);
    return kFailed;
  }
  if (!opened.advice.empty()) spdlog::warn(opened.advice);
  MappingServer server(config, *opened.bus, log_change, {},
                       output.empty() ? Results::kNone : Results::kKept);
  const MetricsServer::Opened metrics = open_metrics(config, server);
  if (!metrics.problem.empty()) {
    spdlog::error(metrics.problem);
    return kFailed;
  }
  spdlog::info("listening on {}", config.lcm_url);
  bool healthy = true;
  while (healthy && !signals.arrived() && !server.told_to_stop()) {
    healthy = opened.bus->receive(std::chrono::milliseconds(100));
    memory.give_back_sometimes();
  }
  if (!healthy) spdlog::error("LCM broke off at {}", config.lcm_url);
  if (server.told_to_stop()) spdlog::info("shut down by command");
  server.stop();
  spdlog::info("stopped");
  if (output.empty()) return healthy ? 0 : kFailed;
  if (!server.has_results()) {
    spdlog::warn("no calibrated frame has arrived: nothing is written to {}", output.string());
    return healthy ? 0 : kFailed;
  }
  const std::string problem = server.write_results(output);
  if (!problem.empty()) spdlog::error(problem);
  return healthy && problem.empty() ? 0 : kFailed;
}

int run_check(const std::filesystem::path& file, bool repair) {
  const MapCheck check = check_map(file, repair);
  std::cout << check.said << '\n';
  return check.ok ? 0 : kFailed;
}

int run(const ServerOptions& options, StopSignals& signals) {
  try {
    if (!options.check_map.empty()) return run_check(options.check_map, options.repair);
    const ServerConfig config = effective_config(options);
    if (options.print_config) {
      std::cout << config_text(config) << '\n';
      return 0;
    }
    if (!options.log.log.empty())
      return run_logged(options.log, options.sequence.output, config, signals);
    if (!options.sequence.sequence.empty()) return run_recorded(options.sequence, config, signals);
    return run_live(config, options.sequence.output, signals);
  } catch (const std::invalid_argument& error) {
    spdlog::error(error.what());
    return kBadOptions;
  } catch (const std::exception& error) {
    spdlog::error(error.what());
    return kFailed;
  }
}

}  // namespace

int main(int argc, char** argv) {
  StopSignals signals;
  cv::setNumThreads(1);  // one mapping thread is the whole plan; results must not depend on cores
  spdlog::set_default_logger(spdlog::stderr_color_mt("eifmap-server"));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
  ServerOptions options;
  CLI::App app("Maps cameras' images: publishes each one's poses and map of points.",
               "eifmap-server");
  add_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const std::string problem = explain(app, error);
    if (problem.empty()) return 0;
    spdlog::error(problem);
    return kBadOptions;
  }
  if (const std::string problem = mixed_options(app); !problem.empty()) {
    spdlog::error(problem);
    return kBadOptions;
  }
  return run(options, signals);
}
