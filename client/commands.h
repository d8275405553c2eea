// The commands of `eifmap`: each adds its options to the program and, when it was chosen, runs.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "client/stop_signals.h"

namespace eifmap {

inline constexpr int kFailed = 1;
inline constexpr int kBadOptions = 2;
inline constexpr const char* kDefaultUrl = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";

using Command = std::function<int(StopSignals&)>;

// Each returns what to call when its subcommand was parsed.
Command add_publish_command(CLI::App& app);
Command add_log_command(CLI::App& app);
Command add_eval_command(CLI::App& app);

}  // namespace eifmap
