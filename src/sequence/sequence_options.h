// What a user adds to images that come without it.
#pragma once

#include <filesystem>
#include <string>

namespace eifmap {

struct SequenceOptions {
  std::filesystem::path calibration;  // read_camera(); "": the images' own
  double hfov_deg = 0;                // > 0: guess a pinhole that sees so much from left to right
  double rate_hz = 0;                 // > 0: of images without times

  std::string problem() const;  // "" or which is wrong and why
};

}  // namespace eifmap
