#include "map/nis_monitor.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace eifmap {
namespace {

// Sigmas of the ratio that chance is allowed.
constexpr double kChance = 4;
// The ratio is known within these, beyond which a gated sample says next to nothing of it.
constexpr double kLeast = 1e-4, kMost = 16;

// F_d(a), of which F_d+2(a) = F_d(a) - (a/2)^(d/2) exp(-a/2) / Gamma(d/2 + 1).
double chi_square_below(int degrees, double limit) {
  double below = degrees % 2 == 0 ? 1 - std::exp(-limit / 2) : std::erf(std::sqrt(limit / 2));
  for (int d = degrees % 2 == 0 ? 2 : 1; d < degrees; d += 2)
    below -= std::exp(0.5 * d * std::log(limit / 2) - limit / 2 - std::lgamma(0.5 * d + 1));
  return below;
}

// The ratio s^2 with s^2 M(g^2 / s^2) = mean: the left side rises with it.
double ratio_of(double mean, int degrees, double gate) {
  double low = kLeast, high = kMost;
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(low * high);
    const double expected = middle * truncated_chi_square_mean(degrees, gate * gate / middle);
    (expected < mean ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

NisRatio ratio_of(const NisSum& sum, int degrees, double gate, double variance_factor) {
  NisRatio result;
  result.count = sum.count;
  result.beyond = sum.beyond;
  const double free = degrees * sum.count - sum.fitted;
  if (!(free > 0)) return {};
  const double mean = sum.squared * degrees / free;
  // Near the gate little of the ratio is left in the mean.
  const double chance = std::min(0.9, std::sqrt(2 * variance_factor / free));
  result.ratio = ratio_of(mean, degrees, gate);
  result.sigma = 0.5 * (ratio_of((1 + chance) * mean, degrees, gate) -
                        ratio_of((1 - chance) * mean, degrees, gate));
  return result;
}

void accumulate(const NisSum& sum, NisSum& total) {
  if (sum.count == 0) return;
  total.squared += sum.squared;
  total.count += sum.count;
  total.beyond += sum.beyond;
  total.fitted += sum.fitted;
}

bool is_off(const NisRatio& r) {
  if (r.count == 0) return false;
  const double chance = 1 + kChance * r.sigma / r.ratio;
  return r.ratio > NisMonitor::kSuspect * chance || r.ratio * NisMonitor::kSuspect * chance < 1;
}

}  // namespace

double truncated_chi_square_mean(int degrees, double limit) {
  const double below = chi_square_below(degrees, limit);
  // Of a limit that is next to nothing: uniform in the ball.
  if (limit < 1e-3) return limit * degrees / (degrees + 2);
  return degrees * chi_square_below(degrees + 2, limit) / below;
}

void NisMonitor::add(const Innovations& innovations, double variance_factor) {
  window_.push_back(innovations);
  if (window_.size() > kWindow) window_.pop_front();
  Innovations total;
  for (const Innovations& one : window_) {
    accumulate(one.sights, total.sights);
    accumulate(one.edges, total.edges);
  }
  ratios_[static_cast<std::size_t>(InnovationKind::kSight)] =
      ratio_of(total.sights, 2, kSightNisGate, variance_factor);
  ratios_[static_cast<std::size_t>(InnovationKind::kEdge)] =
      ratio_of(total.edges, 5, kEdgeNisGate, variance_factor);
  alarm_ = window_.size() >= kFewest && std::any_of(ratios_.begin(), ratios_.end(), is_off);
}

std::string NisMonitor::detail(double sigma_factor) const {
  std::ostringstream text;
  text.precision(2);
  const auto say = [&](InnovationKind kind, const char* what) {
    const NisRatio& r = ratio(kind);
    if (!is_off(r)) return;
    if (text.tellp() > 0) text << "; ";
    text << "the residuals of " << r.count << ' ' << what << " are " << std::sqrt(r.ratio)
         << " times what the keypoints' sigmas say";
  };
  say(InnovationKind::kSight, "sights");
  say(InnovationKind::kEdge, "relative poses");
  const NisRatio& sights = ratio(InnovationKind::kSight);
  if (is_off(sights))
    text << "; a sigma_factor of " << sigma_factor * std::sqrt(sights.ratio) << " would fit";
  return text.str();
}

void NisMonitor::warn(FrameResult& result, double sigma_factor) const {
  if (!alarm_ || result.state != TrackingState::kTracking) return;
  if (result.reason != Reason::kNone) return;
  result.reason = Reason::kSigmaSuspect;
  result.detail = detail(sigma_factor);
}

}  // namespace eifmap
