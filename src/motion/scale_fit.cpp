#include "motion/scale_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "geometry/robust.h"

namespace eifmap {
namespace {

// A feature counts as an inlier within this many spreads (norm of two dimensions, 99 %).
constexpr double kInlierSigma = 3.0349;
// Half width of a vote, in its own standard deviations. Wider than noise, since the guess's
// rotation and direction are a little off.
constexpr double kVoteSigma = 4;
constexpr std::size_t kMaxCandidates = 192;

// A map feature on the offsetting model: u(d) = (s_x - d p_x) / (s_z - d p_z). [WD10] (3)
struct Offset {
  Eigen::Vector3d s;   // R_jW (X_f - X_jG)
  Eigen::Vector2d uv;  // measured
  double sigma;
};

// What one feature alone says of d.
struct Vote {
  double d, sigma_d;
  double weight;  // how informative it is, 0 to 1
};

class OffsettingModel {
 public:
  OffsettingModel(const Eigen::Vector3d& centre_i, const Rigid3& world_from_guess,
                  std::span<const MapObservation> observations) {
    const Eigen::Matrix3d r_jw = world_from_guess.matrix().transpose();
    const Eigen::Vector3d& x_jg = world_from_guess.translation;
    p_ = r_jw * (centre_i - x_jg);  // [WD10] (2)
    offsets_.reserve(observations.size());
    for (const MapObservation& o : observations)
      offsets_.push_back({r_jw * (o.point - x_jg), o.x, o.sigma});
  }

  std::size_t size() const { return offsets_.size(); }

  // Whitened residual of feature f at d, and its derivative. False when f is behind the camera.
  bool residual(std::size_t f, double d, Eigen::Vector2d& r, Eigen::Vector2d* derivative) const {
    const Offset& o = offsets_[f];
    const Eigen::Vector3d in_j = o.s - d * p_;  // [WD10] (4)
    if (!(in_j.z() > 1e-6 * in_j.norm())) return false;
    const Eigen::Vector2d uv = in_j.hnormalized();
    r = (o.uv - uv) / o.sigma;
    // d(uv)/dd = (-p_xy + uv p_z) / depth
    if (derivative) *derivative = (uv * p_.z() - p_.head<2>()) / (in_j.z() * o.sigma);
    return true;
  }

  // d in closed form: A d = C and B d = D in the least-squares sense. False when the feature says
  // nothing (on the epipole), lies behind the camera there, or misses its epipolar line by more
  // than `max_miss` standard deviations whatever d is.
  bool vote(std::size_t f, double max_miss, Vote& vote) const {
    const Offset& o = offsets_[f];
    const Eigen::Vector2d ab = p_.head<2>() - o.uv * p_.z();    // A, B
    const Eigen::Vector2d cd = o.s.head<2>() - o.uv * o.s.z();  // C, D
    const double ab2 = ab.squaredNorm();
    if (!(ab2 > 1e-18 * p_.squaredNorm())) return false;
    vote.d = cd.dot(ab) / ab2;
    Eigen::Vector2d r;
    if (!residual(f, vote.d, r, nullptr)) return false;
    const double miss = r.norm();
    if (!(miss < max_miss)) return false;
    vote.sigma_d = (o.s.z() - vote.d * p_.z()) * o.sigma / std::sqrt(ab2);
    vote.weight = bisquare_weight(miss, max_miss);
    return true;
  }

 private:
  Eigen::Vector3d p_;
  std::vector<Offset> offsets_;
};

// Sum of the votes near d.
double score_at(double d, const std::vector<Vote>& votes) {
  double score = 0;
  for (const Vote& v : votes) score += v.weight * bisquare_weight(d - v.d, kVoteSigma * v.sigma_d);
  return score;
}

std::vector<Vote> cast_votes(const OffsettingModel& model, double max_miss) {
  std::vector<Vote> votes;
  votes.reserve(model.size());
  std::vector<double> sigmas;
  Vote vote;
  for (std::size_t f = 0; f < model.size(); ++f) {
    if (!model.vote(f, max_miss, vote)) continue;
    votes.push_back(vote);
    sigmas.push_back(vote.sigma_d);
  }
  // A feature near the epipole agrees with any d: it must not vote for all of them.
  const double usual = take_median(sigmas);
  for (Vote& v : votes) v.weight *= std::min(1.0, usual / v.sigma_d);
  std::sort(votes.begin(), votes.end(), [](const Vote& a, const Vote& b) { return a.d < b.d; });
  return votes;
}

struct Mode {
  double d = 0, score = 0;
};

// The highest score at any vote that `allowed` lets stand as a candidate.
template <typename Allowed>
Mode best_mode(const std::vector<Vote>& votes, const Allowed& allowed) {
  Mode best;
  const std::size_t stride = 1 + votes.size() / kMaxCandidates;
  for (std::size_t k = 0; k < votes.size(); k += stride) {
    if (!allowed(votes[k])) continue;
    const double score = score_at(votes[k].d, votes);
    if (score > best.score) best = {votes[k].d, score};
  }
  return best;
}

struct Estimate {
  double d = 0, sigma_d = std::numeric_limits<double>::infinity();
  double spread = 1;
};

// One step of iteratively reweighted least squares with bisquare weights: [WD10] III-D. `e.spread`
// says how wide. Leaves in `sizes` the residuals that had a part. False when none had.
bool reweighted_step(const OffsettingModel& model, double bisquare, Estimate& e,
                     std::vector<double>& sizes, double& change) {
  const double limit = bisquare * e.spread;
  double information = 0, gradient = 0;
  sizes.clear();
  Eigen::Vector2d r, j;
  for (std::size_t f = 0; f < model.size(); ++f) {
    if (!model.residual(f, e.d, r, &j)) continue;
    const double size = r.norm();
    if (!(size < limit)) continue;
    sizes.push_back(size);
    const double weight = bisquare_weight(size, limit);
    information += weight * j.squaredNorm();
    gradient += weight * j.dot(r);
  }
  if (!(information > 0)) return false;
  change = gradient / information;
  e.sigma_d = e.spread / std::sqrt(information);
  e.d += change;
  return true;
}

constexpr int kSteps = 20;

// From one mode of the votes. The spread is of the residuals below the limit, and clamped.
Estimate fit_from(double d, const OffsettingModel& model, const ScaleFitOptions& options) {
  Estimate e;
  e.d = d;
  e.spread = options.max_spread;
  std::vector<double> sizes;
  double change = 0;
  for (int step = 0; step < kSteps; ++step) {
    if (!reweighted_step(model, options.bisquare, e, sizes, change)) return {};
    if (step > 4 && std::abs(change) < 1e-3 * e.sigma_d) break;
    e.spread = std::clamp(kSpreadFromMedian2d * take_median(sizes), 1.0, options.max_spread);
  }
  return e;
}

// From the guess, d = 0. The spread is of all residuals, whatever it is.
Estimate fit_plainly(const OffsettingModel& model, const ScaleFitOptions& options) {
  constexpr double kMinSpread = 1e-6;  // exact data has none
  Estimate e;
  std::vector<double> sizes;
  Eigen::Vector2d r;
  double change = 0;
  for (int step = 0; step < kSteps; ++step) {
    sizes.clear();
    for (std::size_t f = 0; f < model.size(); ++f)
      if (model.residual(f, e.d, r, nullptr)) sizes.push_back(r.norm());
    e.spread = std::max(kMinSpread, kSpreadFromMedian2d * take_median(sizes));
    if (!reweighted_step(model, options.bisquare, e, sizes, change)) break;
    if (std::abs(change) < 1e-3 * e.sigma_d) break;
  }
  return e;
}

// The whole map's disagreement with d, at one limit for all estimates so that they compare.
double cost_of(double d, const OffsettingModel& model, const ScaleFitOptions& options) {
  const double limit = options.bisquare * options.max_spread;
  double cost = 0;
  Eigen::Vector2d r;
  for (std::size_t f = 0; f < model.size(); ++f)
    cost += bisquare_cost(model.residual(f, d, r, nullptr) ? r.norm() : limit, limit);
  return cost;
}

int classify(const Estimate& e, const OffsettingModel& model, std::vector<std::uint8_t>& inlier) {
  int number = 0;
  Eigen::Vector2d r;
  inlier.assign(model.size(), 0);
  for (std::size_t f = 0; f < model.size(); ++f) {
    inlier[f] = model.residual(f, e.d, r, nullptr) && r.norm() < kInlierSigma * e.spread;
    number += inlier[f];
  }
  return number;
}

// Votes that cannot mean `d`, not even with all their noise and the spread of the fit.
auto far_from(double d, double spread) {
  return [d, spread](const Vote& v) {
    return std::abs(v.d - d) > 2 * kVoteSigma * spread * v.sigma_d;
  };
}

// The best two modes of the votes, each fitted; the better fit. No sigma when nobody votes.
Estimate fit_by_votes(const OffsettingModel& model, const ScaleFitOptions& options,
                      double& runner_up) {
  const std::vector<Vote> votes = cast_votes(model, options.bisquare * options.max_spread);
  const Mode first = best_mode(votes, [](const Vote&) { return true; });
  if (first.score <= 0) return {};
  Estimate best = fit_from(first.d, model, options);
  const Mode second = best_mode(votes, far_from(best.d, best.spread));
  double other_score = second.score, best_score = score_at(best.d, votes);
  if (second.score > 0) {
    const Estimate other = fit_from(second.d, model, options);
    if (cost_of(other.d, model, options) < cost_of(best.d, model, options)) {
      best = other;
      best_score = score_at(best.d, votes);
      other_score = best_mode(votes, far_from(best.d, best.spread)).score;
    }
  }
  runner_up = best_score > 0 ? other_score / best_score : 1;
  return best;
}

}  // namespace

std::string ScaleFitOptions::problem() const {
  if (min_inliers < 1) return "scale_fit.min_inliers must be at least 1";
  if (!(min_inlier_ratio >= 0 && min_inlier_ratio <= 1))
    return "scale_fit.min_inlier_ratio must be in [0, 1]";
  if (!(max_relative_sigma > 0)) return "scale_fit.max_relative_sigma must be above 0";
  if (!(max_runner_up > 0)) return "scale_fit.max_runner_up must be above 0";
  if (!(bisquare >= 1)) return "scale_fit.bisquare must be at least 1";
  if (!(max_spread >= 1)) return "scale_fit.max_spread must be at least 1";
  return "";
}

ScaleFit fit_scale(const Eigen::Vector3d& centre_i, const Rigid3& world_from_guess,
                   std::span<const MapObservation> observations, const ScaleFitOptions& options) {
  if (const std::string problem = options.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  const Eigen::Vector3d to_i = centre_i - world_from_guess.translation;
  if (!(to_i.norm() > 0)) throw std::invalid_argument("fit_scale: the guess is at centre_i");

  ScaleFit fit;
  fit.world_from_j = world_from_guess;
  fit.inlier.assign(observations.size(), 0);
  const OffsettingModel model(centre_i, world_from_guess, observations);
  const Estimate best = options.method == ScaleFitMethod::kVote
                            ? fit_by_votes(model, options, fit.runner_up)
                            : fit_plainly(model, options);
  if (!std::isfinite(best.sigma_d)) return fit;

  fit.d = best.d;
  fit.sigma_d = best.sigma_d;
  fit.baseline = std::abs(1 - best.d) * to_i.norm();
  fit.sigma_baseline = best.sigma_d * to_i.norm();
  fit.world_from_j.translation += best.d * to_i;  // [WD10] (5)
  fit.num_inliers = classify(best, model, fit.inlier);
  fit.inlier_ratio =
      static_cast<double>(fit.num_inliers) / static_cast<double>(observations.size());
  const bool accepted = fit.num_inliers >= options.min_inliers &&
                        fit.inlier_ratio >= options.min_inlier_ratio &&
                        fit.sigma_baseline < options.max_relative_sigma * fit.baseline &&
                        fit.runner_up < options.max_runner_up;
  if (accepted) fit.reason = Reason::kNone;
  return fit;
}

}  // namespace eifmap
