// What eifmap-server is told on its command line.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "server/config.h"
#include "server/log_run.h"
#include "server/sequence_run.h"

namespace eifmap {

struct ServerOptions {
  std::string config_file, lcm_url, camera, input, maps_folder, secret_file;
  std::filesystem::path check_map;
  bool localize_only = false, repair = false;
  std::optional<int> metrics_port;
  bool print_config = false, paper = false;
  SequenceRunOptions sequence;
  LogRunOptions log;
};

void add_options(CLI::App& app, ServerOptions& options);

// Options of one way to run with another one: "" or which, and what to do.
std::string mixed_options(const CLI::App& app);

// The preset's values, then the file's, then the command line's. Throws std::invalid_argument.
ServerConfig effective_config(const ServerOptions& options);

}  // namespace eifmap
