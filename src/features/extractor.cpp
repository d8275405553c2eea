#include "features/extractor.h"

#include <stdexcept>

namespace eifmap {
namespace {

constexpr int kSmallestImage = 32;  // px

void check_image(const cv::Mat& gray) {
  if (gray.type() != CV_8UC1) throw std::invalid_argument("features: the image must be CV_8UC1");
  if (gray.cols < kSmallestImage || gray.rows < kSmallestImage)
    throw std::invalid_argument("features: the image must be at least 32x32");
}

}  // namespace

std::string FeatureOptions::problem() const {
  if (max_features < 1 || max_features > 100000)
    return "max_features is " + std::to_string(max_features) + ": must be 1 to 100000";
  if (const std::string problem = surf.problem(); !problem.empty()) return problem;
  if (const std::string problem = sift.problem(); !problem.empty()) return problem;
  return roll.problem();
}

FeatureExtractor::FeatureExtractor(const FeatureOptions& options)
    : options_(options), roll_(options.roll), surf_(options.surf) {
  if (const std::string problem = options.problem(); !problem.empty())
    throw std::invalid_argument("features." + problem);
}

Extractor FeatureExtractor::id() const {
  switch (options_.extractor) {
    case ExtractorKind::kSurfUpright:
    case ExtractorKind::kAuto:
      break;
    case ExtractorKind::kSurfOriented:
      return Extractor::kSurfOriented;
    case ExtractorKind::kSift:
      return Extractor::kSift;
  }
  return Extractor::kSurfUpright;
}

Features FeatureExtractor::extract(const cv::Mat& gray, const Camera& camera) {
  check_image(gray);
  if (options_.extractor == ExtractorKind::kAuto) return extract_levelled(gray, camera);
  if (options_.extractor == ExtractorKind::kSift)
    return extract_sift(gray, options_.sift, options_.max_features);
  surf_.assign(gray);
  Features features;
  features.keypoints = surf_.find_keypoints(options_.max_features);
  if (options_.extractor == ExtractorKind::kSurfOriented) surf_.orient(features.keypoints);
  features.descriptors = surf_.describe(features.keypoints);
  return features;
}

Features FeatureExtractor::extract_levelled(const cv::Mat& gray, const Camera& camera) {
  if (camera.id() != checked_camera_) {
    if (const std::string problem = camera.problem(); !problem.empty())
      throw std::invalid_argument("features: camera: " + problem);
    checked_camera_ = camera.id();
  }
  surf_.assign(gray);
  const auto describe = [this](std::vector<Keypoint> keypoints, float angle) {
    for (Keypoint& k : keypoints) k.angle = angle;
    return Features{keypoints, surf_.describe(keypoints)};
  };
  const float last = roll_.angle();
  Features features = describe(surf_.find_keypoints(options_.max_features), last);
  roll_.follow(features, camera, [&describe](const std::vector<Keypoint>& some, float angle) {
    return describe(some, angle).descriptors;
  });
  if (roll_.angle() == last) return features;
  return describe(std::move(features.keypoints), roll_.angle());
}

}  // namespace eifmap
