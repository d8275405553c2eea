#include "sequence/layout.h"

#include <cmath>

#include "geometry/camera.h"
#include "sequence/camera_file.h"
#include "sequence/text_lines.h"

namespace eifmap {
namespace fs = std::filesystem;
namespace {

constexpr const Layout* kLayouts[] = {&kOwnLayout, &kEurocLayout, &kTumLayout, &kKittiLayout,
                                      &kImagesLayout};
constexpr double kAssumedRate = 10;  // Hz

}  // namespace

std::string SequenceOptions::problem() const {
  if (hfov_deg != 0 && !(hfov_deg >= kMinHfovDeg && hfov_deg <= kMaxHfovDeg))
    return "--hfov is " + std::to_string(hfov_deg) + ", wanted 10 to 150 degrees";
  if (hfov_deg != 0 && !calibration.empty())
    return "--hfov guesses what --calib " + calibration.string() + " says: leave one of them out";
  if (!(rate_hz >= 0 && rate_hz <= 10000))
    return "--rate is " + std::to_string(rate_hz) + ", wanted above 0, at most 10000 Hz";
  return "";
}

const Layout* find_layout(const fs::path& folder) {
  for (const Layout* layout : kLayouts)
    if (layout->recognizes(folder)) return layout;
  return nullptr;
}

std::string known_layouts() {
  std::string text;
  for (const Layout* layout : kLayouts) {
    if (!text.empty()) text += "; ";
    text += std::string(layout->files) + " (" + layout->name + ")";
  }
  return text;
}

void assume_times(Recording& recording, const SequenceOptions& options) {
  const bool told = options.rate_hz > 0;
  const double rate = told ? options.rate_hz : kAssumedRate;
  for (std::size_t i = 0; i < recording.images.size(); ++i)
    recording.times_us.push_back(std::llround(1e6 * static_cast<double>(i) / rate));
  if (told) return;
  recording.notes.push_back(
      "the images have no times: 10 images a second are assumed; --rate HZ says otherwise");
}

std::string read_times(const fs::path& file, Recording& recording) {
  const std::string problem = for_each_line(
      file, [&recording](const auto& words) { return add_seconds(words[0], recording.times_us); });
  const std::size_t times = recording.times_us.size(), images = recording.images.size();
  if (!problem.empty() || times == images) return problem;
  return file.string() + ": has " + std::to_string(times) + " times for " + std::to_string(images) +
         " images; wanted one each";
}

void read_own_calibration(const fs::path& folder, Recording& recording) {
  const fs::path calibration = folder / "calib.json";
  std::error_code error;
  if (!recording.problem.empty() || !fs::exists(calibration, error)) return;
  const CameraFile file = read_camera(calibration);
  recording.problem = file.problem;
  recording.camera = file.camera;
  recording.calibration = "calib.json";
}

std::string read_image_list(const fs::path& list, const fs::path& folder, AddTime add_time,
                            Recording& recording) {
  const std::string problem = for_each_line(list, [&](const auto& words) -> std::string {
    if (words.size() < 2) return "'" + words[0] + "' alone; wanted a time and an image's name";
    if (std::string wrong = add_time(words[0], recording.times_us); !wrong.empty()) return wrong;
    recording.images.push_back(folder / words[1]);
    std::error_code error;
    if (!fs::is_regular_file(recording.images.back(), error))
      return recording.images.back().string() +
             " is not there; take the line out, or add the image";
    return "";
  });
  if (!problem.empty()) return problem;
  return recording.images.empty() ? list.string() + ": lists no images" : "";
}

}  // namespace eifmap
