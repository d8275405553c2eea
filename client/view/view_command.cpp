#include <spdlog/spdlog.h>

#include "bus/lcm_bus.h"
#include "client/commands.h"
#include "client/view/page_server.h"

namespace eifmap {
namespace {

using std::chrono::milliseconds;

struct Options {
  std::string camera, lcm_url = kDefaultLcmUrl;
  ListenAt at;
};

int run(const Options& options, StopSignals& signals) {
  if (!options.camera.empty() && !valid_camera_name(options.camera)) {
    spdlog::error("--camera is '{}', wanted 1 to 24 characters of A-Z a-z 0-9 _ -", options.camera);
    return kBadOptions;
  }
  if (const std::string problem = form_problem(options.at); !problem.empty()) {
    spdlog::error(problem);
    return kBadOptions;
  }
  View view;
  const PageServer::Opened opened = PageServer::open(options.at, view);
  if (!opened.server) {
    spdlog::error(opened.problem);
    return kFailed;
  }
  const LcmBus::Opened bus = LcmBus::open(options.lcm_url);
  if (!bus.bus) {
    spdlog::error(bus.problem);
    return kFailed;
  }
  if (!bus.advice.empty()) spdlog::warn(bus.advice);
  ViewFeed feed(options.camera, view, *bus.bus);
  if (!options.at.loopback())
    spdlog::warn("whoever reaches {} can look at the map", options.at.address);
  spdlog::info("open {} in a browser; what is shown comes from {}", opened.server->url(),
               options.lcm_url);
  bool chosen = !options.camera.empty();
  while (!signals.arrived()) {
    if (!bus.bus->receive(milliseconds(10))) {
      spdlog::error("LCM broke off at {}: start `eifmap view` again", options.lcm_url);
      return kFailed;
    }
    feed.tick();
    if (!chosen && !feed.camera().empty()) {
      spdlog::info("camera {} is shown, the first that a server spoke of; --camera names another",
                   feed.camera());
      chosen = true;
    }
    opened.server->service();
  }
  return 0;
}

}  // namespace

Command add_view_command(CLI::App& app) {
  auto* command =
      app.add_subcommand("view", "show a server's poses and map live, on a page for the browser");
  const auto options = std::make_shared<Options>();
  command->add_option("--camera", options->camera, "default: the first that a server speaks of");
  command->add_option("--address", options->at.address,
                      "IPv4 address to serve the page at; 0.0.0.0: all of this machine's");
  command->add_option("--port", options->at.port, "of the page; 0: any free one");
  command->add_option("--lcm-url", options->lcm_url, "network to listen on");
  command->get_option("--address")->capture_default_str();
  command->get_option("--port")->capture_default_str();
  return [command, options](StopSignals& signals) {
    return command->parsed() ? run(*options, signals) : -1;
  };
}

}  // namespace eifmap
