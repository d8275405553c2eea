// The figures of a server's statuses in Prometheus' text format, version 0.0.4.
#pragma once

#include <eifmap/status_t.hpp>
#include <string>
#include <vector>

namespace eifmap {

// One family of samples after the other, each with its HELP and TYPE; samples of a camera have its
// name as the label `camera`. Units are seconds and bytes, and the map's own, which are metres
// where eifmap_map_is_metric is 1. Of the status without a camera: figures of the whole server.
std::string metrics_text(const std::vector<status_t>& statuses);

// Whether a figure by this key (status_t's diagnostics) is among them.
bool is_metric(const std::string& diagnostic_key);

}  // namespace eifmap
