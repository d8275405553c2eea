#include "features/roll_follower.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace eifmap {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kPerSign = 150;
constexpr std::size_t kMinFeatures = 30;  // fewer: as good as no image
constexpr double kMinMatched = 0.25;      // of the reference's features
constexpr double kMinInlierRatio = 0.6;   // of them
constexpr double kNoisePx = 0.5;
constexpr double kMaxSpread = 2.5;  // of the noise: beyond, the fit is not at its minimum
constexpr int kPatience =
    10;  // images in a row that do not match; then the next one is the reference
// Images in a row without a match, dark ones too, after which the last roll tells nothing: a camera
// that was carried on unseen is rather held as at its first image.
constexpr int kMemory = 30;
// Steps in which a turned image is looked for: half of one is what upright descriptors bear.
constexpr int kSteps = 12;
constexpr double kLeastStep = kPi / 180;
// Looking along the line called down, which way it points in the image is soon noise: there the
// direction that it has in the image is called down from then on.
constexpr double kLeastDown = 0.3;

// By how much to turn descriptors: 0 in the dead band, all of the roll from twice that on.
double with_dead_band(double roll, double band) {
  const double size = std::abs(roll);
  const double turned = std::clamp(2 * (size - band), 0.0, size);
  return roll < 0 && turned > 0 ? -turned : turned;
}

std::size_t group_of(const Keypoint& keypoint) {
  return keypoint.laplacian_sign < 0 ? 0 : 1;
}

std::vector<std::int8_t> descriptors_of(const Features& features,
                                        const std::vector<std::size_t>& indices) {
  std::vector<std::int8_t> descriptors;
  descriptors.reserve(indices.size() * kDescriptorSize);
  for (const std::size_t i : indices) {
    const auto first =
        features.descriptors.begin() + static_cast<std::ptrdiff_t>(i * kDescriptorSize);
    descriptors.insert(descriptors.end(), first, first + kDescriptorSize);
  }
  return descriptors;
}

}  // namespace

std::string RollOptions::problem() const {
  if (!(dead_band_deg >= 0 && dead_band_deg <= 45))
    return "roll.dead_band_deg is " + std::to_string(dead_band_deg) + ": must be 0 to 45";
  return "";
}

RollFollower::Strongest::Strongest(const Features& features, const Camera& camera) {
  std::array<int, 2> counts{};
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    const Keypoint& k = features.keypoints[i];
    if (counts[group_of(k)] >= kPerSign) continue;
    const Eigen::Vector2d x = camera.normalized_from_pixel({k.u, k.v});
    if (!x.allFinite()) continue;  // beyond kMaxViewAngle
    ++counts[group_of(k)];
    indices.push_back(i);
    keypoints.push_back(k);
    bearings.push_back(x.homogeneous().normalized());
  }
  set_descriptors(descriptors_of(features, indices));
}

void RollFollower::Strongest::set_descriptors(const std::vector<std::int8_t>& descriptors) {
  groups = {};
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    FeatureGroup& group = groups[group_of(keypoints[i])];
    group.index.push_back(static_cast<int>(i));
    const auto first = descriptors.begin() + static_cast<std::ptrdiff_t>(i * kDescriptorSize);
    group.descriptors.insert(group.descriptors.end(), first, first + kDescriptorSize);
  }
}

double RollFollower::roll() const {
  return std::remainder(std::atan2(last_.down.y(), last_.down.x()) - kPi / 2, 2 * kPi);
}

// A step of a degree at a time: each costs describing the image once more.
void RollFollower::set_angle() {
  const double wanted = with_dead_band(roll(), options_.dead_band_deg * kPi / 180);
  if (wanted == 0 || std::abs(std::remainder(wanted - angle_, 2 * kPi)) > kLeastStep)
    angle_ = static_cast<float>(wanted);
}

// Finds the image's down from the reference's.
bool RollFollower::match_with_reference(Strongest& image, double noise) {
  std::vector<BearingPair> pairs;
  for (std::size_t s = 0; s < reference_.groups.size(); ++s)
    for (const Match& m : match(reference_.groups[s], image.groups[s], {}))
      pairs.push_back({reference_.bearings[static_cast<std::size_t>(m.a)],
                       image.bearings[static_cast<std::size_t>(m.b)]});
  if (static_cast<double>(pairs.size()) < kMinMatched * static_cast<double>(reference_.size()))
    return false;
  const TurnFit fit = fit_turn(pairs, noise, turn_);
  if (fit.num_inliers < kMinInlierRatio * static_cast<double>(pairs.size())) return false;
  if (fit.sigma > kMaxSpread * noise) return false;
  image.down = fit.turn.rotation.transpose() * reference_.down;
  turn_ = fit.turn;
  return true;
}

// The image may have turned further than its descriptors bear.
bool RollFollower::match_turned(Strongest& image, double noise, const Describe& describe) {
  const float last = angle_;
  for (int step = 1; step <= kSteps / 2; ++step)
    for (const int side : {1, -1}) {
      const double turned = last + side * step * 2 * kPi / kSteps;
      image.set_descriptors(describe(image.keypoints, static_cast<float>(turned)));
      if (match_with_reference(image, noise)) return true;
    }
  image.set_descriptors(describe(image.keypoints, last));
  return false;
}

void RollFollower::take_as_reference(Strongest image) {
  reference_ = std::move(image);
  turn_.reset();
}

void RollFollower::follow(const Features& features, const Camera& camera,
                          const Describe& describe) {
  Strongest image(features, camera);
  sure_ = false;
  ++images_since_match_;
  if (image.size() < kMinFeatures) return;
  if (reference_.size() == 0) take_as_reference(image);

  const double noise = kNoisePx * camera.radians_per_pixel();
  sure_ = match_with_reference(image, noise);
  if (!sure_) {
    take_as_reference(last_.size() > 0 ? last_ : reference_);
    sure_ = match_with_reference(image, noise) || match_turned(image, noise, describe);
  }
  const bool forgotten = images_since_match_ >= kMemory;
  if (!sure_ && ++images_unmatched_ < kPatience && !forgotten) return;
  if (!sure_) {
    image.down = forgotten ? Eigen::Vector3d::UnitY().eval() : last_.down;
    take_as_reference(image);
  }
  images_unmatched_ = 0;
  if (sure_ || forgotten) images_since_match_ = 0;
  last_ = std::move(image);
  if (std::hypot(last_.down.x(), last_.down.y()) < kLeastDown) {
    last_.down = Eigen::Vector3d(last_.down.x(), last_.down.y(), 0).normalized();
    take_as_reference(last_);
  }
  set_angle();
}

}  // namespace eifmap
