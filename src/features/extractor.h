// Gray images in, features out: the one way from pixels to what the mapper sees, whichever detector
// and descriptor.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <utility>

#include "features/features.h"
#include "features/sift.h"
#include "features/surf.h"
#include "frame.h"
#include "geometry/camera.h"

namespace eifmap {

enum class ExtractorKind {
  kSurfUpright,   // for cameras that stay about level: fastest, tells up from right
  kSurfOriented,  // each feature in the frame of its own dominant orientation
  kSift,          // oriented, too; slow and a little more certain
};

// As a user writes them.
inline constexpr std::array kExtractorNames{
    std::pair{"surf_upright", ExtractorKind::kSurfUpright},
    std::pair{"surf_oriented", ExtractorKind::kSurfOriented},
    std::pair{"sift", ExtractorKind::kSift}};

struct FeatureOptions {
  ExtractorKind extractor = ExtractorKind::kSurfUpright;
  int max_features = 1000;  // per image
  SurfOptions surf;
  SiftOptions sift;

  std::string problem() const;  // "" or which field is wrong and why
};

class FeatureExtractor {
 public:
  // Throws std::invalid_argument with options.problem().
  explicit FeatureExtractor(const FeatureOptions& options = {});

  // What descriptors are compared by: those of another id never match.
  Extractor id() const;

  // `gray`: CV_8UC1, at least 32x32, of `camera`. A pure function of the images so far. Throws
  // std::invalid_argument on another type or size.
  Features extract(const cv::Mat& gray, const Camera& camera);

 private:
  FeatureOptions options_;
};

}  // namespace eifmap
