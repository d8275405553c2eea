#include "sequence/camera_choice.h"

#include <cstdio>

#include "sequence/camera_file.h"

namespace eifmap {
namespace {

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

CameraChoice guessed(const std::string& source, const cv::Size& size, double hfov_deg) {
  CameraChoice choice;
  choice.from = "--hfov";
  if (size.empty()) {
    choice.problem = source +
                     ": the first image cannot be read, and --hfov needs its size; put it "
                     "there again";
    return choice;
  }
  choice.camera = camera_of_view(size.width, size.height, hfov_deg);
  char text[256];
  std::snprintf(
      text, sizeof(text),
      "the calibration is GUESSED: a pinhole of f = %.1f px from --hfov %g, square pixels, "
      "centre in the middle, no distortion; a calibration by --calib FILE is better",
      choice.camera.fx, hfov_deg);
  choice.note = text;
  choice.problem = choice.camera.problem();
  return choice;
}

CameraChoice chosen(const SequenceOptions& options, const std::string& source,
                    const std::optional<Camera>& own, const std::string& own_name,
                    const cv::Size& first) {
  if (!options.calibration.empty()) {
    const CameraFile file = read_camera(options.calibration);
    return {file.camera, options.calibration.string(), "", file.problem};
  }
  if (own && options.hfov_deg > 0)
    return {{},
            "",
            "",
            source + ": --hfov would put a guess in the place of " + own_name +
                "; leave it out, or give another calibration by --calib FILE"};
  if (own) return {*own, own_name, "", ""};
  if (options.hfov_deg > 0) return guessed(source, first, options.hfov_deg);
  return {{},
          "",
          "",
          source +
              ": has no calibration; give it by --calib FILE (calib.json, or camera_info as "
              "YAML), or have it guessed by --hfov DEGREES, what the camera sees from left to "
              "right"};
}

}  // namespace

CameraChoice choose_camera(const SequenceOptions& options, const std::string& source,
                           const std::optional<Camera>& own, const std::string& own_name,
                           const cv::Size& first) {
  CameraChoice choice = chosen(options, source, own, own_name, first);
  const Camera& camera = choice.camera;
  if (!choice.problem.empty() || first.empty() ||
      (first.width == camera.width && first.height == camera.height))
    return choice;
  choice.problem = source + ": the images are " + size_text(first.width, first.height) + ", but " +
                   choice.from + " says " + size_text(camera.width, camera.height) +
                   "; give the calibration of these images by --calib FILE";
  return choice;
}

}  // namespace eifmap
