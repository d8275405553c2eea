// eifmap: what a user of a running eifmap-server needs on the other end of the network.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "client/commands.h"
#include "program/command_line.h"

int main(int argc, char** argv) {
  using namespace eifmap;
  StopSignals signals;
  spdlog::set_default_logger(spdlog::stderr_color_mt("eifmap"));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
  CLI::App app("Feeds an eifmap-server with images, and takes its poses and maps.", "eifmap");
  app.set_version_flag("--version", EIFMAP_VERSION);
  app.require_subcommand(1);
  const Command commands[] = {add_publish_command(app), add_log_command(app), add_eval_command(app),
                              add_view_command(app), add_ctl_command(app)};
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const std::string problem = explain(app, error);
    if (problem.empty()) return 0;
    spdlog::error(problem);
    return kBadOptions;
  }
  try {
    for (const Command& command : commands)
      if (const int code = command(signals); code >= 0) return code;
  } catch (const std::exception& error) {
    spdlog::error(error.what());
  }
  return kFailed;
}
