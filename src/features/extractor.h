// Gray images in, features out: the one way from pixels to what the mapper sees, whichever detector
// and descriptor.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <utility>

#include "features/features.h"
#include "features/roll_follower.h"
#include "features/sift.h"
#include "features/surf.h"
#include "frame.h"
#include "geometry/camera.h"

namespace eifmap {

enum class ExtractorKind {
  kSurfUpright,   // for cameras that stay about level: fastest, tells up from right
  kSurfOriented,  // each feature in the frame of its own dominant orientation
  kSift,          // oriented, too; slow
  // upright in a frame that follows the camera's roll, as seen from image to image: surf_upright,
  // bit for bit, while the camera is about level, and comparable with it
  kAuto,
};

// As a user writes them.
inline constexpr std::array kExtractorNames{
    std::pair{"surf_upright", ExtractorKind::kSurfUpright},
    std::pair{"surf_oriented", ExtractorKind::kSurfOriented},
    std::pair{"sift", ExtractorKind::kSift}, std::pair{"auto", ExtractorKind::kAuto}};

struct FeatureOptions {
  ExtractorKind extractor = ExtractorKind::kAuto;
  int max_features = 1000;  // per image
  SurfOptions surf;
  SiftOptions sift;
  RollOptions roll;

  std::string problem() const;  // "" or which field is wrong and why
};

class FeatureExtractor {
 public:
  // Throws std::invalid_argument with options.problem().
  explicit FeatureExtractor(const FeatureOptions& options = {});

  // What descriptors are compared by: those of another id never match.
  Extractor id() const;

  // `gray`: CV_8UC1, at least 32x32, of `camera`. kAuto: a pure function of the images so far, else
  // of this one. Throws std::invalid_argument on another type or size; kAuto: with
  // camera.problem(), too.
  Features extract(const cv::Mat& gray, const Camera& camera);

  // kAuto: by how much the last image is turned against the first, rad in [-pi, pi], +u towards +v;
  // and whether that could be seen in it, or is still the one before's.
  double roll() const { return roll_.roll(); }
  bool roll_is_sure() const { return roll_.sure(); }

 private:
  Features extract_levelled(const cv::Mat& gray, const Camera& camera);

  FeatureOptions options_;
  RollFollower roll_;
  SurfImage surf_;                   // the last image
  std::int64_t checked_camera_ = 0;  // id of the last one: usable
};

}  // namespace eifmap
