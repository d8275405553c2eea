// A folder with images and nothing else, in the natural order of their names; a calib.json beside
// them is read.
#include <algorithm>

#include "sequence/image_file.h"
#include "sequence/layout.h"

namespace eifmap {
namespace fs = std::filesystem;
namespace {

bool recognizes(const fs::path& folder) {
  std::vector<fs::path> images;
  return list_images(folder, images).empty();
}

Recording read(const fs::path& folder, const SequenceOptions& options) {
  Recording recording;
  recording.problem = list_images(folder, recording.images);
  if (!recording.problem.empty()) return recording;
  std::sort(recording.images.begin(), recording.images.end(),
            [](const fs::path& a, const fs::path& b) {
              return natural_less(a.filename().string(), b.filename().string());
            });
  assume_times(recording, options);
  if (options.calibration.empty()) read_own_calibration(folder, recording);
  return recording;
}

}  // namespace

const Layout kImagesLayout{"plain", "images alone", &recognizes, &read};

}  // namespace eifmap
