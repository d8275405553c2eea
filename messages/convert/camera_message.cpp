#include "convert/camera_message.h"

#include <algorithm>

#include "wire/channel.h"
#include "wire/layout.h"
#include "wire/limits.h"

namespace eifmap {
namespace {

void scan(LayoutScanner& in) {
  in.skip(8);  // utime
  in.string("camera", kMaxText);
  in.skip(8 + 4 + 4 + 2 + 4 * 8);  // calibration_id, width, height, model, fx fy cx cy
  in.array("distortion", in.count("num_distortion", kMaxDistortion), 8);
}

std::string shape_problem(const camera_t& message) {
  if (!valid_camera_name(message.camera)) return "the camera's name is not 1 to 24 of A-Za-z0-9_-";
  if (!valid_time(message.utime)) return "utime is " + std::to_string(message.utime);
  return "";
}

std::string number_problem(const camera_t& message) {
  if (!valid_image_side(message.width) || !valid_image_side(message.height))
    return "width x height is " + std::to_string(message.width) + " x " +
           std::to_string(message.height) + ", each must be 1 to " + std::to_string(kMaxImageSide);
  if (message.model < camera_t::MODEL_PINHOLE || message.model > camera_t::MODEL_FISHEYE)
    return "model is " + std::to_string(message.model) + ", must be 0, 1 or 2";
  const double numbers[] = {message.fx, message.fy, message.cx, message.cy};
  if (!all_finite(numbers, 4) || !all_finite(message.distortion.data(), message.distortion.size()))
    return "a number is not finite";
  return "";
}

}  // namespace

camera_t to_message(const NamedCamera& named) {
  const Camera& camera = named.camera;
  camera_t message;
  message.utime = named.time_us;
  message.camera = named.name;
  message.calibration_id = camera.id();
  message.width = camera.width;
  message.height = camera.height;
  message.model = static_cast<std::int16_t>(camera.model);
  message.fx = camera.fx;
  message.fy = camera.fy;
  message.cx = camera.cx;
  message.cy = camera.cy;
  message.num_distortion = static_cast<std::int32_t>(camera.distortion.size());
  message.distortion.assign(camera.distortion.begin(), camera.distortion.end());
  return message;
}

Decoded<NamedCamera> decode_camera(Bytes bytes) {
  using Result = Decoded<NamedCamera>;
  const Decoded<camera_t> decoded = decode_checked<camera_t>(bytes, scan);
  if (!decoded.ok()) return Result::refuse(decoded.reason, decoded.detail);
  const camera_t& message = decoded.value;
  if (std::string problem = shape_problem(message); !problem.empty())
    return Result::refuse(Reason::kMalformedMessage, problem);
  if (std::string problem = number_problem(message); !problem.empty())
    return Result::refuse(Reason::kBadCalibration, problem);

  Result result;
  result.value.time_us = message.utime;
  result.value.name = message.camera;
  Camera& camera = result.value.camera;
  camera.width = message.width;
  camera.height = message.height;
  camera.model = static_cast<CameraModel>(message.model);
  camera.fx = message.fx;
  camera.fy = message.fy;
  camera.cx = message.cx;
  camera.cy = message.cy;
  std::copy(message.distortion.begin(), message.distortion.end(), camera.distortion.begin());
  if (std::string problem = camera.problem(); !problem.empty())
    return Result::refuse(Reason::kBadCalibration, problem);
  if (message.calibration_id != 0 && message.calibration_id != camera.id())
    return Result::refuse(Reason::kBadCalibration,
                          "calibration_id is " + std::to_string(message.calibration_id) +
                              ", but these numbers' is " + std::to_string(camera.id()));
  return result;
}

}  // namespace eifmap
