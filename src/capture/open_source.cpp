#include "capture/open_source.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "capture/capture_source.h"

namespace eifmap {
namespace fs = std::filesystem;
namespace {

bool is_number(const std::string& text) {
  return !text.empty() && text.size() < 4 &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

OpenedSource open_source(const std::string& what, const SequenceOptions& options) {
  if (const std::string problem = options.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  std::error_code error;
  if (fs::is_directory(what, error)) {
    auto opened = RecordedSequence::open(what, options);
    if (!opened.sequence) return {nullptr, opened.problem};
    return {make_source(std::move(*opened.sequence)), ""};
  }
  if (is_image(what) && fs::is_regular_file(what, error))
    return {nullptr, what + ": is a single image; give the folder that holds the images"};
  if (fs::is_regular_file(what, error)) return open_video(what, options);
  if (is_number(what)) return open_device("/dev/video" + what, options);
  if (what.starts_with("/dev/")) return open_device(what, options);
  return {nullptr, what +
                       ": does not exist; give a folder of images, a video file, or a camera as "
                       "/dev/videoN or N"};
}

}  // namespace eifmap
