// Which calibration images get: the one that the user gives, their own, or a guess.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "geometry/camera.h"
#include "sequence/sequence_options.h"

namespace eifmap {

struct CameraChoice {
  Camera camera;
  std::string from;     // what it was read from, for messages
  std::string note;     // "" or what the user must know: a guess
  std::string problem;  // "" or a sentence that names the options that help
};

// `source`: what the images are called. `own`: their calibration, where they have one, read from
// `own_name`. `first`, an image: its size must be the calibration's; empty (it cannot be read) is
// passed over unless a guess needs it.
CameraChoice choose_camera(const SequenceOptions& options, const std::string& source,
                           const std::optional<Camera>& own, const std::string& own_name,
                           const cv::Size& first);

}  // namespace eifmap
