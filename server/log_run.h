// The mapper over an LCM event log, without a network.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "server/config.h"
#include "server/sequence_run.h"

namespace eifmap {

struct LogRunOptions {
  std::filesystem::path log;  // as lcm-logger writes it
  std::filesystem::path output;
  bool verify = false;  // what is not as it was in the recorded run is a problem
  std::optional<std::int64_t>
      epoch;  // of the run to make again; nothing: the one that decided most
  // Of that run. Its camera: map that one alone; its network and input are of no meaning here.
  ServerConfig config;
};

struct LogRunResult {
  std::string problem;  // "" or what went wrong
  std::string summary;  // "" or what was done, in words
};

// As fast as it can, in the caller's thread. What it writes: as run_sequence(), of several cameras
// into output/CAMERA. A log that is cut or corrupt is mapped up to there, which is noted, and with
// `verify` a problem. Throws std::invalid_argument with config.problem().
LogRunResult run_log(const LogRunOptions& options, const Progress& progress, const Note& note);

}  // namespace eifmap
