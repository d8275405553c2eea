// Videos and cameras through OpenCV's videoio; open_source() is what to call.
#pragma once

#include <filesystem>

#include "capture/open_source.h"

namespace eifmap {

// Times: the container's where they increase, else by its rate, else by options.rate_hz or 10 Hz.
OpenedSource open_video(const std::filesystem::path& file, const SequenceOptions& options);

// Live, by V4L2. Times: the clock when an image arrived.
OpenedSource open_device(const std::filesystem::path& device, const SequenceOptions& options);

}  // namespace eifmap
