// In the place of capture_source.cpp where eifmap is built without videoio.
#include "capture/capture_source.h"

namespace eifmap {

OpenedSource open_video(const std::filesystem::path& file, const SequenceOptions&) {
  return {nullptr,
          file.string() +
              ": is no folder, and this eifmap was built without videos (EIFMAP_VIDEO=OFF); "
              "give a folder of its images"};
}

OpenedSource open_device(const std::filesystem::path& device, const SequenceOptions&) {
  return {nullptr, device.string() +
                       ": this eifmap was built without cameras (EIFMAP_VIDEO=OFF); publish its "
                       "images by a driver of yours"};
}

}  // namespace eifmap
