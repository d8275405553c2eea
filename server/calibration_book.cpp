#include "server/calibration_book.h"

#include <stdexcept>
#include <utility>

#include "convert/camera_message.h"
#include "convert/feature_message.h"
#include "convert/image_message.h"
#include "server/image_decoder.h"

namespace eifmap {
namespace {

// Calibrations kept while it is open which camera is mapped.
constexpr std::size_t kMaxCameras = 64;

// Of a frame that can be read and names no calibration; else 0x0.
std::pair<int, int> size_of(const Channel& channel, Bytes bytes) {
  if (channel.kind == ChannelKind::kImage) {
    const Decoded<ImageMessage> image = decode_image(bytes);
    if (image.ok() && image.value.calibration_id == 0)
      return {image.value.width, image.value.height};
  } else {
    const Decoded<FeatureFrame> frame = decode_features(bytes);
    if (frame.ok() && frame.value.calibration_id == 0)
      return {frame.value.width, frame.value.height};
  }
  return {0, 0};
}

}  // namespace

const Camera* CalibrationBook::of(const std::string& camera) const {
  if (given_) return &*given_;
  const auto found = in_use_.find(camera);
  return found == in_use_.end() ? nullptr : &found->second;
}

Taken CalibrationBook::take(const std::string& camera, Bytes bytes, bool is_mapped) {
  const Decoded<NamedCamera> decoded = decode_camera(bytes);
  if (!decoded.ok()) return {decoded.reason, decoded.detail};
  const Camera& calibration = decoded.value.camera;
  if (std::string problem = camera_problem(decoded.value.name, camera); !problem.empty())
    return {Reason::kMalformedMessage, std::move(problem)};
  const Camera* known = of(camera);
  if (known && known->id() == calibration.id()) return {};
  if (given_)
    return {Reason::kCalibrationMismatch,
            "the configuration's calibration is another, and is used"};
  if (!known && in_use_.size() >= kMaxCameras)
    return {Reason::kBadCalibration, "calibrations of too many cameras"};
  if (known && is_mapped) {
    waiting_[camera] = calibration;
    return {};
  }
  const bool was_guessed = guessed_.erase(camera) > 0;
  if (known && !was_guessed) waiting_[camera] = *known;
  in_use_[camera] = calibration;
  return {};
}

bool CalibrationBook::guess(const Channel& channel, Bytes bytes) {
  if (of(channel.camera) || hfov_deg_ <= 0 || in_use_.size() >= kMaxCameras) return false;
  const auto [width, height] = size_of(channel, bytes);
  if (width == 0 || !size_problem(width, height).empty()) return false;
  in_use_[channel.camera] = camera_of_view(width, height, hfov_deg_);
  guessed_.insert(channel.camera);
  return true;
}

void CalibrationBook::withdraw_guess(const std::string& camera) {
  if (guessed_.erase(camera) > 0) in_use_.erase(camera);
}

const Camera& CalibrationBook::of_frame(const std::string& camera, std::int64_t id, int width,
                                        int height) const {
  const Camera* known = of(camera);
  if (!known) throw std::out_of_range("CalibrationBook: no calibration of camera " + camera);
  const auto found = waiting_.find(camera);
  if (found == waiting_.end() || id == known->id()) return *known;
  const Camera& waiting = found->second;
  if (id != 0) return id == waiting.id() ? waiting : *known;
  const bool fits_known = width == known->width && height == known->height && !is_guessed(camera);
  const bool fits_waiting = width == waiting.width && height == waiting.height;
  return fits_waiting && !fits_known ? waiting : *known;
}

void CalibrationBook::change(const std::string& camera) {
  std::swap(in_use_.at(camera), waiting_.at(camera));
  if (guessed_.erase(camera) > 0) waiting_.erase(camera);
}

}  // namespace eifmap
