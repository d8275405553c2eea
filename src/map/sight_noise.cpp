#include "map/sight_noise.h"

#include <algorithm>
#include <cmath>

namespace eifmap {

SightNoise::SightNoise(const MapperOptions& options)
    : least_(options.sigma_factor),
      largest_(options.sigma_factor * options.max_sigma_growth),
      factor_(options.sigma_factor),
      estimate_(options.sigma_factor) {}

double SightNoise::follow(const FilterUpdate& update) {
  constexpr int kEnough = 30;  // sights
  // About three keyframes' mean: how much the errors are depends on how the camera moves, too.
  constexpr double kGain = 0.3;
  // The larger the map, the dearer is looking at all of its sights again.
  constexpr double kWorthIt = 1.25, kPerKeyframe = 0.001;
  if (update.num_newest < kEnough) return 1;
  // Sights were judged by the factor that they had.
  const double seen = std::clamp(factor_ * update.newest_spread, least_ / 2, 2 * largest_);
  estimate_ = std::clamp(estimate_ * std::pow(seen / estimate_, kGain), least_, largest_);
  const double change = estimate_ / factor_;
  const double worth_it = kWorthIt + kPerKeyframe * keyframes_++;
  if (change < worth_it && change > 1 / worth_it) return 1;
  factor_ = estimate_;
  return change;
}

double SightNoise::include(const SightNoise& other) {
  const double change = std::max(factor_, other.factor_) / factor_;
  factor_ = std::max(factor_, other.factor_);
  estimate_ = std::max(estimate_, other.estimate_);
  keyframes_ += other.keyframes_;
  return change;
}

}  // namespace eifmap
