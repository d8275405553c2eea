#include "convert/feature_message.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "frame_check.h"
#include "wire/channel.h"
#include "wire/layout.h"
#include "wire/limits.h"

namespace eifmap {
namespace {

// After fingerprint, utime, publisher and seq.
constexpr std::size_t kPartOffset = 8 + 8 + 8 + 8;

void scan(LayoutScanner& in) {
  in.skip(8 + 8 + 8 + 2 + 2);  // utime, publisher, seq, part, num_parts
  in.string("camera", kMaxText);
  in.skip(8 + 4 + 4 + 2 + 2);  // calibration_id, width, height, extractor, extractor_version
  const std::size_t n = in.count("n", kMaxFeatures);
  in.array("u v sigma_px scale angle response", n, 6 * 4);
  in.array("laplacian_sign", n, 1);
  in.skip(4);  // descriptor_size
  in.array("descriptors", in.count("descriptor_bytes", kMaxFeatures * kDescriptorSize), 1);
}

std::string shape_problem(const feature_frame_t& message) {
  if (!valid_camera_name(message.camera)) return "the camera's name is not 1 to 24 of A-Za-z0-9_-";
  if (!valid_time(message.utime)) return "utime is " + std::to_string(message.utime);
  if (!valid_seq(message.seq)) return "seq is " + std::to_string(message.seq);
  if (message.num_parts < 1 || message.num_parts > kMaxFeatureParts || message.part < 0 ||
      message.part >= message.num_parts)
    return "part is " + std::to_string(message.part) + " of " + std::to_string(message.num_parts);
  // They were dealt out one by one, so that all parts together are a frame, too.
  const int parts = message.num_parts;
  if (message.n > (static_cast<int>(kMaxFeatures) + parts - 1) / parts)
    return std::to_string(message.n) + " features in one of " + std::to_string(parts) + " parts";
  if (!valid_image_side(message.width) || !valid_image_side(message.height))
    return "width x height is " + std::to_string(message.width) + " x " +
           std::to_string(message.height);
  if (message.descriptor_size != kDescriptorSize ||
      message.descriptor_bytes != message.n * kDescriptorSize)
    return std::to_string(message.n) + " features with descriptors of " +
           std::to_string(message.descriptor_size) + " bytes each, " +
           std::to_string(message.descriptor_bytes) + " together; each must have " +
           std::to_string(kDescriptorSize);
  return "";
}

FeatureFrame from_message(const feature_frame_t& message) {
  FeatureFrame frame;
  frame.time_us = message.utime;
  frame.publisher = message.publisher;
  frame.seq = message.seq;
  frame.camera = message.camera;
  frame.calibration_id = message.calibration_id;
  frame.width = message.width;
  frame.height = message.height;
  frame.extractor = static_cast<Extractor>(message.extractor);
  frame.extractor_version = message.extractor_version;
  frame.keypoints.resize(static_cast<std::size_t>(message.n));
  for (std::size_t i = 0; i < frame.keypoints.size(); ++i)
    frame.keypoints[i] = {
        message.u[i],     message.v[i],        message.sigma_px[i],      message.scale[i],
        message.angle[i], message.response[i], message.laplacian_sign[i]};
  frame.descriptors.resize(message.descriptors.size());
  if (!frame.descriptors.empty())
    std::memcpy(frame.descriptors.data(), message.descriptors.data(), frame.descriptors.size());
  return frame;
}

bool known_extractor(std::int16_t extractor) {
  return extractor >= feature_frame_t::EXTRACTOR_SURF_UPRIGHT &&
         extractor <= feature_frame_t::EXTRACTOR_SIFT;
}

}  // namespace

feature_frame_t to_message(const FeatureFrame& frame) {
  const std::size_t n = frame.keypoints.size();
  if (frame.descriptors.size() != n * kDescriptorSize)
    throw std::invalid_argument("descriptors: must be 64 bytes a keypoint");
  feature_frame_t message;
  message.utime = frame.time_us;
  message.publisher = frame.publisher;
  message.seq = frame.seq;
  message.part = 0;
  message.num_parts = 1;
  message.camera = frame.camera;
  message.calibration_id = frame.calibration_id;
  message.width = frame.width;
  message.height = frame.height;
  message.extractor = static_cast<std::int16_t>(frame.extractor);
  message.extractor_version = frame.extractor_version;
  message.n = static_cast<std::int32_t>(n);
  for (const Keypoint& k : frame.keypoints) {
    message.u.push_back(k.u);
    message.v.push_back(k.v);
    message.sigma_px.push_back(k.sigma_px);
    message.scale.push_back(k.scale);
    message.angle.push_back(k.angle);
    message.response.push_back(k.response);
    message.laplacian_sign.push_back(k.laplacian_sign);
  }
  message.descriptor_size = kDescriptorSize;
  message.descriptor_bytes = static_cast<std::int32_t>(frame.descriptors.size());
  message.descriptors.assign(frame.descriptors.begin(), frame.descriptors.end());
  return message;
}

Decoded<FeaturePart> decode_feature_part(Bytes bytes) {
  using Result = Decoded<FeaturePart>;
  const Decoded<feature_frame_t> decoded = decode_checked<feature_frame_t>(bytes, scan);
  if (!decoded.ok()) return Result::refuse(decoded.reason, decoded.detail);
  if (std::string problem = shape_problem(decoded.value); !problem.empty())
    return Result::refuse(Reason::kMalformedMessage, problem);
  if (!known_extractor(decoded.value.extractor))
    return Result::refuse(Reason::kUnknownExtractor,
                          "extractor " + std::to_string(decoded.value.extractor));
  Result result;
  FeatureFrame& frame = result.value.frame;
  frame = from_message(decoded.value);
  result.value.part = decoded.value.part;
  result.value.num_parts = decoded.value.num_parts;
  for (std::size_t i = 0; i < frame.keypoints.size(); ++i)
    if (std::string problem = keypoint_problem(frame.keypoints[i], frame.width, frame.height);
        !problem.empty())
      return Result::refuse(Reason::kBadFeatures, "feature " + std::to_string(i) + ": " + problem);
  return result;
}

Decoded<FeatureFrame> decode_features(Bytes bytes) {
  using Result = Decoded<FeatureFrame>;
  Decoded<FeaturePart> part = decode_feature_part(bytes);
  if (!part.ok()) return Result::refuse(part.reason, std::move(part.detail));
  if (part.value.num_parts != 1)
    return Result::refuse(Reason::kMalformedMessage,
                          "part " + std::to_string(part.value.part) + " of " +
                              std::to_string(part.value.num_parts) + ", wanted a whole frame");
  Result result;
  result.value = std::move(part.value.frame);
  return result;
}

bool is_part_of_features(Bytes bytes) {
  constexpr std::size_t kNumParts = kPartOffset + 2;
  if (bytes.size() < kNumParts + 2) return false;
  return (bytes[kNumParts] << 8 | bytes[kNumParts + 1]) > 1;
}

bool is_first_part(Bytes bytes) {
  return bytes.size() >= kPartOffset + 2 && bytes[kPartOffset] == 0 && bytes[kPartOffset + 1] == 0;
}

}  // namespace eifmap
