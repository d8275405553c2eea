#include "features/sift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/features2d.hpp>
#include <tuple>

#include "features/descriptor_bytes.h"
#include "features/gaussian_derivatives.h"
#include "features/image_pyramid.h"
#include "features/integral_image.h"
#include "features/surf_orientation.h"

namespace eifmap {
namespace {

constexpr double kFirstSigma = 1.6;  // px, of the first layer (Lowe 2004, 3.3)
constexpr int kLevels = 6;           // of the pyramid for the Laplacian
// OpenCV doubles the image first and then halves coordinates, which moves pixel centres.
constexpr float kShift = -0.25f;  // px
constexpr float kRadiansPerDegree = static_cast<float>(std::numbers::pi / 180);

using CvKeypoints = std::vector<cv::KeyPoint>;

cv::Ptr<cv::SIFT> make_detector(const SiftOptions& options) {
  return cv::SIFT::create(0, options.octave_layers, options.contrast_threshold,
                          options.edge_threshold, kFirstSigma);
}

// Sigma of the Gaussian blob that responds most. OpenCV says twice that of the narrower of the two
// Gaussians; the difference of two responds as the Laplacian at their geometric mean.
double scale_of(const cv::KeyPoint& k, const SiftOptions& options) {
  return 0.5 * k.size * std::exp2(0.5 / options.octave_layers);
}

// Radians between two directions.
double between(double a, double b) {
  return std::abs(std::remainder(a - b, 2 * std::numbers::pi));
}

// OpenCV gives a blob with several dominant orientations several times, and a measurement must not
// count twice: the one nearest to the orientation that SURF finds stays.
CvKeypoints one_per_blob(CvKeypoints found, const cv::Mat& gray, const SiftOptions& options) {
  const auto blob_of = [](const cv::KeyPoint& k) { return std::tuple(k.pt.y, k.pt.x, k.size); };
  std::sort(found.begin(), found.end(), [&](const cv::KeyPoint& a, const cv::KeyPoint& b) {
    return std::tuple(blob_of(a), a.angle) < std::tuple(blob_of(b), b.angle);
  });
  const IntegralImage integral(gray);
  CvKeypoints blobs;
  for (auto first = found.begin(); first != found.end();) {
    const auto last = std::find_if(
        first, found.end(), [&](const cv::KeyPoint& k) { return blob_of(k) != blob_of(*first); });
    auto best = first;
    if (last - first > 1) {
      const float wanted = surf_orientation(integral, first->pt.x + kShift, first->pt.y + kShift,
                                            static_cast<float>(scale_of(*first, options)));
      const auto distance = [wanted](const cv::KeyPoint& k) {
        return between(k.angle * kRadiansPerDegree, wanted);
      };
      best = std::min_element(first, last, [&](const cv::KeyPoint& a, const cv::KeyPoint& b) {
        return distance(a) < distance(b);
      });
    }
    blobs.push_back(*best);
    first = last;
  }
  return blobs;
}

// Standard deviation of the place, each axis: as the scale over the response. Fitted to warped
// images like SURF's, with the same floor and the same allowance for parallax.
float sigma_of_place(float scale, float response) {
  constexpr float kFloor = 0.1f, kFactor = 0.0006f, kFaintest = 0.001f;
  return std::hypot(kFloor, kFactor * scale / std::max(kFaintest, response));
}

Keypoint keypoint_of(const cv::KeyPoint& k, const ImagePyramid& pyramid,
                     const SiftOptions& options) {
  const double scale = scale_of(k, options);
  Keypoint keypoint;
  keypoint.u = std::max(0.0f, k.pt.x + kShift);
  keypoint.v = std::max(0.0f, k.pt.y + kShift);
  keypoint.scale = static_cast<float>(scale);
  keypoint.sigma_px = sigma_of_place(keypoint.scale, k.response);
  keypoint.angle = k.angle * kRadiansPerDegree;
  keypoint.response = k.response;
  const GaussianDerivatives d =
      gaussian_derivatives(pyramid, keypoint.u, keypoint.v, std::max(1.0, scale));
  keypoint.laplacian_sign = d.of[0][2] + d.of[2][0] < 0 ? -1 : 1;
  return keypoint;
}

// 4x4 cells of 8 directions each become 4x4 of 4: the difference of opposite directions, of square
// roots as if distances were Hellinger's. Measured on rendered pairs: as many matches as with all
// 128 numbers, and more of them right; sums of neighbouring directions lose both.
void compress(const float* histograms, std::int8_t* descriptor) {
  constexpr std::size_t kDirections = 8, kPairs = kDirections / 2;
  std::array<double, kDescriptorSize> values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float* cell = histograms + i / kPairs * kDirections;
    const std::size_t direction = i % kPairs;
    values[i] = std::sqrt(static_cast<double>(cell[direction])) -
                std::sqrt(static_cast<double>(cell[direction + kPairs]));
  }
  write_descriptor(values, descriptor);
}

}  // namespace

std::string SiftOptions::problem() const {
  const auto wrong = [](const char* field, auto value, const char* right) {
    return std::string("sift.") + field + " is " + std::to_string(value) + ": must be " + right;
  };
  if (octave_layers < 1 || octave_layers > 8)
    return wrong("octave_layers", octave_layers, "1 to 8");
  if (!(contrast_threshold >= 0) || !(contrast_threshold < 1))
    return wrong("contrast_threshold", contrast_threshold, "at least 0 and below 1");
  if (!(edge_threshold >= 1) || !(edge_threshold <= 1000))
    return wrong("edge_threshold", edge_threshold, "1 to 1000");
  return "";
}

Features extract_sift(const cv::Mat& gray, const SiftOptions& options, int max_features) {
  const cv::Ptr<cv::SIFT> detector = make_detector(options);
  CvKeypoints found;
  detector->detect(gray, found);
  found = one_per_blob(std::move(found), gray, options);

  const ImagePyramid pyramid(gray, kLevels);
  std::vector<Keypoint> keypoints;
  keypoints.reserve(found.size());
  for (const cv::KeyPoint& k : found) keypoints.push_back(keypoint_of(k, pyramid, options));

  Features features;
  CvKeypoints kept;
  for (const std::size_t i :
       best_keypoints(keypoints, gray.cols, gray.rows, static_cast<std::size_t>(max_features))) {
    features.keypoints.push_back(keypoints[i]);
    kept.push_back(found[i]);
  }
  if (kept.empty()) return features;
  cv::Mat histograms;
  detector->compute(gray, kept, histograms);
  features.descriptors.resize(features.keypoints.size() * kDescriptorSize);
  for (std::size_t i = 0; i < features.keypoints.size(); ++i)
    compress(histograms.ptr<float>(static_cast<int>(i)),
             &features.descriptors[i * kDescriptorSize]);
  return features;
}

}  // namespace eifmap
