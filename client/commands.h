// The commands of `eifmap`: each adds its options to the program and, when it was chosen, runs.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "bus/default_url.h"
#include "bus/stop_signals.h"

namespace eifmap {

inline constexpr int kFailed = 1;
inline constexpr int kBadOptions = 2;

using Command = std::function<int(StopSignals&)>;

// Each returns what to call when its subcommand was parsed.
Command add_publish_command(CLI::App& app);
Command add_log_command(CLI::App& app);
Command add_eval_command(CLI::App& app);
Command add_view_command(CLI::App& app);
Command add_ctl_command(CLI::App& app);

}  // namespace eifmap
