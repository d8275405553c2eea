#include "features/quality.h"

#include <numbers>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "features/extractor.h"
#include "features/images.h"

namespace eifmap::testing {
namespace {

constexpr int kWidth = 480, kHeight = 360;
constexpr int kMaxFeatures = 600;

struct Described {
  FeatureFrame frame;   // keypoints; descriptors of our own methods
  cv::Mat descriptors;  // of OpenCV's
};

Described describe_ours(const cv::Mat& image, ExtractorKind kind) {
  FeatureOptions options;
  options.extractor = kind;
  options.max_features = kMaxFeatures;
  Features features = FeatureExtractor(options).extract(image, {});
  Described described;
  described.frame.keypoints = std::move(features.keypoints);
  described.frame.descriptors = std::move(features.descriptors);
  return described;
}

// `shift`: px, what its places are off by.
Described describe_opencv(const cv::Mat& image, cv::Feature2D& method, float shift) {
  std::vector<cv::KeyPoint> keypoints;
  method.detect(image, keypoints);
  cv::KeyPointsFilter::retainBest(keypoints, kMaxFeatures);
  Described described;
  method.compute(image, keypoints, described.descriptors);
  for (const cv::KeyPoint& k : keypoints) {
    Keypoint place;
    place.u = k.pt.x + shift;
    place.v = k.pt.y + shift;
    place.scale = 0.5f * k.size;
    described.frame.keypoints.push_back(place);
  }
  return described;
}

Described describe(const cv::Mat& image, Method method) {
  switch (method) {
    case Method::kSurfUpright:
      return describe_ours(image, ExtractorKind::kSurfUpright);
    case Method::kSurfOriented:
      return describe_ours(image, ExtractorKind::kSurfOriented);
    case Method::kSift:
      return describe_ours(image, ExtractorKind::kSift);
    case Method::kOpenCvAkaze:
      return describe_opencv(image, *cv::AKAZE::create(), 0);
    case Method::kOpenCvSift:
      break;
  }
  // It doubles the image first and then halves coordinates: known, and not held against it.
  return describe_opencv(image, *cv::SIFT::create(), -0.25f);
}

// The nearest of each, where it is much nearer than the second.
std::vector<int> nearest(const cv::Mat& from, const cv::Mat& to, int norm, float max_ratio) {
  std::vector<std::vector<cv::DMatch>> found;
  cv::BFMatcher(norm).knnMatch(from, to, found, 2);
  std::vector<int> of(static_cast<std::size_t>(from.rows), -1);
  for (const std::vector<cv::DMatch>& m : found)
    if (m.size() == 2 && m[0].distance <= max_ratio * m[1].distance)
      of[static_cast<std::size_t>(m[0].queryIdx)] = m[0].trainIdx;
  return of;
}

// Ratio and mutual, as the mapper's.
IndexPairs match_opencv(const cv::Mat& a, const cv::Mat& b) {
  const int norm = a.type() == CV_8U ? cv::NORM_HAMMING : cv::NORM_L2;
  const std::vector<int> of_a = nearest(a, b, norm, static_cast<float>(MatchOptions().max_ratio));
  const std::vector<int> of_b = nearest(b, a, norm, 1);
  IndexPairs pairs;
  for (std::size_t i = 0; i < of_a.size(); ++i)
    if (of_a[i] >= 0 && of_b[static_cast<std::size_t>(of_a[i])] == static_cast<int>(i))
      pairs.emplace_back(static_cast<int>(i), of_a[i]);
  return pairs;
}

IndexPairs match_both(const Described& a, const Described& b) {
  return a.descriptors.empty() ? match_signs(a.frame, b.frame)
                               : match_opencv(a.descriptors, b.descriptors);
}

// About the image's centre, which moves by a part of a pixel, too.
Eigen::Matrix3d a_from_b(const Change& change) {
  const double angle = change.turn_deg * std::numbers::pi / 180;
  Eigen::Matrix3d centre = Eigen::Matrix3d::Identity(), motion;
  centre(0, 2) = 0.5 * kWidth;
  centre(1, 2) = 0.5 * kHeight;
  motion << std::cos(angle) / change.zoom, -std::sin(angle) / change.zoom, 5.3,
      std::sin(angle) / change.zoom, std::cos(angle) / change.zoom, -3.7, change.tilt,
      0.5 * change.tilt, 1;
  return centre * motion * centre.inverse();
}

cv::Mat second_view(const Texture& texture, const Change& change, unsigned seed) {
  cv::Mat image = view(texture, kWidth, kHeight, a_from_b(change), 0, seed);
  if (change.blur_px > 0) cv::GaussianBlur(image, image, {0, 0}, change.blur_px);
  image.convertTo(image, CV_8U, change.gain, 128 * (1 - change.gain));
  return with_noise(image, change.noise, seed);
}

}  // namespace

std::string name(Method method) {
  switch (method) {
    case Method::kSurfUpright:
      return "SURF upright";
    case Method::kSurfOriented:
      return "SURF oriented";
    case Method::kSift:
      return "SIFT, 64 bytes";
    case Method::kOpenCvAkaze:
      return "cv::AKAZE";
    case Method::kOpenCvSift:
      break;
  }
  return "cv::SIFT";
}

std::vector<Change> changes() {
  return {{.name = "small motion", .turn_deg = 3, .zoom = 1.05},
          {.name = "turn of 30 degrees", .turn_deg = 30},
          {.name = "zoom of 1.5", .zoom = 1.5},
          {.name = "perspective", .turn_deg = 3, .tilt = 8e-4},
          {.name = "blur of 1.5 px", .turn_deg = 3, .blur_px = 1.5},
          {.name = "contrast of 0.4", .turn_deg = 3, .gain = 0.4},
          {.name = "noise of 8", .turn_deg = 3, .noise = 8}};
}

std::vector<Row> measure_quality(int pairs) {
  std::vector<Row> rows;
  for (const Change& change : changes()) {
    Row row{.change = change, .of = {}, .features = {}};
    for (int pair = 0; pair < pairs; ++pair) {
      const unsigned seed = static_cast<unsigned>(pair) + 1;
      const Texture texture(seed);
      const cv::Mat a =
          view(texture, kWidth, kHeight, Eigen::Matrix3d::Identity(), change.noise, 2 * seed);
      const cv::Mat b = second_view(texture, change, 2 * seed + 1);
      for (std::size_t m = 0; m < kMethods.size(); ++m) {
        const Described of_a = describe(a, kMethods[m]), of_b = describe(b, kMethods[m]);
        row.features[m] += static_cast<int>(of_a.frame.keypoints.size()) / pairs;
        row.of[m] += compare(of_a.frame.keypoints, of_b.frame.keypoints, match_both(of_a, of_b),
                             a_from_b(change).inverse(), kWidth, kHeight);
      }
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace eifmap::testing
