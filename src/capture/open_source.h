// Opens whatever a user names as the source of images.
#pragma once

#include <memory>
#include <string>

#include "sequence/image_source.h"

namespace eifmap {

struct OpenedSource {
  std::unique_ptr<ImageSource> source;
  std::string problem;  // "" when there is a source, else what is wrong and what to do
};

// `what`: a folder in one of the known layouts, a video file, or a camera: its number, or
// /dev/videoN. Throws std::invalid_argument with options.problem().
OpenedSource open_source(const std::string& what, const SequenceOptions& options = {});

}  // namespace eifmap
