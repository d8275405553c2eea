#include "features/surf.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "features/blob_detector.h"
#include "features/feature_spread.h"
#include "features/surf_descriptor.h"
#include "features/surf_orientation.h"

namespace eifmap {
namespace {

// Of the blobs in order of merit, this many more than wanted are refined: some are twice the same.
constexpr double kSpare = 1.1;
// Coarse maxima looked at, per feature wanted: about every second is no maximum at closer look.
constexpr double kCandidates = 4;

// The coarse maxima to look at, best first.
std::vector<BlobCandidate> preselect(const std::vector<BlobCandidate>& found, int width, int height,
                                     std::size_t count) {
  std::vector<Contender> contenders;
  contenders.reserve(found.size());
  for (const BlobCandidate& c : found)
    contenders.push_back({static_cast<float>(c.x), static_cast<float>(c.y), c.response, c.sign});
  std::vector<BlobCandidate> kept;
  for (const std::size_t i : spread(contenders, width, height, count)) kept.push_back(found[i]);
  return kept;
}

Keypoint keypoint_of(const Blob& blob) {
  return {.u = static_cast<float>(blob.u),
          .v = static_cast<float>(blob.v),
          .sigma_px = static_cast<float>(blob.sigma_px),
          .scale = static_cast<float>(blob.scale),
          .angle = 0,
          .response = static_cast<float>(blob.response),
          .laplacian_sign = static_cast<std::int8_t>(blob.sign)};
}

std::vector<Keypoint> refine(const IntegralImage& integral, const ImagePyramid& pyramid,
                             const std::vector<BlobCandidate>& candidates, std::size_t count) {
  std::vector<Keypoint> keypoints;
  for (const BlobCandidate& candidate : candidates) {
    if (keypoints.size() >= count) break;
    if (const std::optional<Blob> blob = refine_blob(integral, pyramid, candidate))
      keypoints.push_back(keypoint_of(*blob));
  }
  return keypoints;
}

// Neighbouring octaves and neighbouring samples may climb to the same maximum.
bool same_blob(const Keypoint& a, const Keypoint& b) {
  return a.laplacian_sign == b.laplacian_sign && std::abs(a.u - b.u) < 1 &&
         std::abs(a.v - b.v) < 1 &&
         std::abs(a.scale - b.scale) < 0.25f * std::min(a.scale, b.scale);
}

void drop_duplicates(std::vector<Keypoint>& keypoints) {
  std::sort(keypoints.begin(), keypoints.end(), [](const Keypoint& a, const Keypoint& b) {
    return std::tuple(a.v, a.u, a.scale, -a.response) < std::tuple(b.v, b.u, b.scale, -b.response);
  });
  std::vector<bool> dropped(keypoints.size(), false);
  for (std::size_t i = 0; i < keypoints.size(); ++i)
    for (std::size_t k = i + 1; k < keypoints.size() && keypoints[k].v - keypoints[i].v < 1; ++k)
      if (!dropped[i] && !dropped[k] && same_blob(keypoints[i], keypoints[k]))
        dropped[keypoints[i].response < keypoints[k].response ? i : k] = true;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < keypoints.size(); ++i)
    if (!dropped[i]) keypoints[kept++] = keypoints[i];
  keypoints.resize(kept);
}

}  // namespace

std::string SurfOptions::problem() const {
  const auto wrong = [](const char* field, auto value, const char* right) {
    return std::string("surf.") + field + " is " + std::to_string(value) + ": must be " + right;
  };
  if (octaves < 1 || octaves > 6) return wrong("octaves", octaves, "1 to 6");
  if (sampling_step != 1 && sampling_step != 2 && sampling_step != 4)
    return wrong("sampling_step", sampling_step, "1, 2 or 4");
  if (!(min_response >= 0) || !(min_response < 1))
    return wrong("min_response", min_response, "at least 0 and below 1");
  return "";
}

void SurfImage::assign(const cv::Mat& gray) {
  integral_.assign(gray);
  pyramid_.assign(gray, options_.octaves + 2);
}

std::vector<Keypoint> SurfImage::find_keypoints(int max_features) const {
  const int width = integral_.width(), height = integral_.height();
  const auto times_wanted = [max_features](double factor) {
    return static_cast<std::size_t>(factor * max_features) + 16;
  };
  const std::vector<BlobCandidate> found =
      find_blobs(integral_, options_.octaves, options_.sampling_step,
                 static_cast<float>(options_.min_response));
  std::vector<Keypoint> keypoints =
      refine(integral_, pyramid_, preselect(found, width, height, times_wanted(kCandidates)),
             times_wanted(kSpare));
  drop_duplicates(keypoints);
  std::vector<Keypoint> kept;
  for (const std::size_t i :
       best_keypoints(keypoints, width, height, static_cast<std::size_t>(max_features)))
    kept.push_back(keypoints[i]);
  return kept;
}

void SurfImage::orient(std::vector<Keypoint>& keypoints) const {
  for (Keypoint& k : keypoints) k.angle = surf_orientation(integral_, k.u, k.v, k.scale);
}

std::vector<std::int8_t> SurfImage::describe(std::span<const Keypoint> keypoints) const {
  std::vector<std::int8_t> descriptors(keypoints.size() * kDescriptorSize);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const Keypoint& k = keypoints[i];
    surf_descriptor(integral_, k.u, k.v, k.scale, k.angle, &descriptors[i * kDescriptorSize]);
  }
  return descriptors;
}

}  // namespace eifmap
