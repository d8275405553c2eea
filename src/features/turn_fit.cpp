#include "features/turn_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "geometry/rigid3.h"
#include "geometry/robust.h"

namespace eifmap {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;
using Matrix5d = Eigen::Matrix<double, 5, 5>;
using Vector5d = Eigen::Matrix<double, 5, 1>;

constexpr int kMinPairs = 8;
constexpr int kRotationRounds = 8, kEpipolarRounds = 8;
constexpr double kGoodSpread = 1.5;  // of the noise
constexpr double kInlierSigma = 3;   // of a residual of the last fit
constexpr double kSmallStep = 1e-4;  // rad: after it the residuals stay as they are
constexpr double kDamping = 1e-6;    // of the translation's direction, which may be unknown

// The rotation that minimizes sum w |a - R b|^2.
Matrix3d closest_rotation(std::span<const BearingPair> pairs, const std::vector<double>& weights) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t k = 0; k < pairs.size(); ++k)
    sum += weights[k] * pairs[k].a * pairs[k].b.transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

// At right angles to as many of the parallaxes as can be.
Vector3d first_direction(std::span<const BearingPair> pairs, const std::vector<double>& weights,
                         const Matrix3d& rotation) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Vector3d normal = pairs[k].a.cross(rotation * pairs[k].b);
    sum += weights[k] * normal * normal.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(sum).eigenvectors().col(0);
}

Turn start_without_parallax(std::span<const BearingPair> pairs, double noise) {
  std::vector<double> weights(pairs.size(), 1);
  std::vector<double> sizes(pairs.size()), magnitudes;
  Matrix3d rotation = Matrix3d::Identity();
  for (int round = 0; round < kRotationRounds; ++round) {
    rotation = closest_rotation(pairs, weights);
    for (std::size_t k = 0; k < pairs.size(); ++k)
      sizes[k] = (pairs[k].a - rotation * pairs[k].b).norm();
    magnitudes = sizes;
    const double limit = kBisquare * std::max(noise, take_median(magnitudes));
    for (std::size_t k = 0; k < pairs.size(); ++k) weights[k] = bisquare_weight(sizes[k], limit);
  }
  return {rotation, first_direction(pairs, weights, rotation)};
}

// How far a pair is from a common epipolar plane, rad, and its derivative: rotation Exp(w), and
// direction + basis ab.
struct Residual {
  double value;
  Vector5d gradient;
};

Residual residual_of(const BearingPair& pair, const Turn& turn,
                     const Eigen::Matrix<double, 3, 2>& basis) {
  const Vector3d b = turn.rotation * pair.b;
  const Vector3d normal = turn.direction.cross(pair.a);
  const double size = std::sqrt(normal.squaredNorm() + turn.direction.cross(b).squaredNorm());
  const double inverse = 1 / std::max(size, 1e-9);
  Residual residual;
  residual.value = inverse * normal.dot(b);
  residual.gradient.head<3>() = inverse * pair.b.cross(turn.rotation.transpose() * normal);
  residual.gradient.tail<2>() = inverse * (basis.transpose() * pair.a.cross(b));
  return residual;
}

// Evenly over the sphere, of which a direction and its opposite are the same here.
std::array<Vector3d, 7> other_directions() {
  return {Vector3d::UnitX(),
          Vector3d::UnitZ(),
          Vector3d::UnitY(),
          Vector3d(1, 1, 1).normalized(),
          Vector3d(-1, 1, 1).normalized(),
          Vector3d(1, -1, 1).normalized(),
          Vector3d(1, 1, -1).normalized()};
}

// Gauss-Newton. Returns the standard deviation of the residuals.
double fit_epipolar(std::span<const BearingPair> pairs, double noise, Turn& turn) {
  std::vector<Residual> residuals(pairs.size());
  std::vector<double> sizes(pairs.size());
  double sigma = noise;
  for (int round = 0;; ++round) {
    const Eigen::Matrix<double, 3, 2> basis = sphere_basis(turn.direction);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      residuals[k] = residual_of(pairs[k], turn, basis);
      sizes[k] = std::abs(residuals[k].value);
    }
    sigma = std::max(noise, kSpreadFromMedian1d * take_median(sizes));
    if (round == kEpipolarRounds) return sigma;
    Matrix5d information = Matrix5d::Zero();
    Vector5d gradient = Vector5d::Zero();
    for (const Residual& r : residuals) {
      const double weight = bisquare_weight(r.value, kBisquare * sigma);
      if (weight == 0) continue;
      information += weight * r.gradient * r.gradient.transpose();
      gradient -= weight * r.value * r.gradient;
    }
    information.diagonal().array() += kDamping * information.trace();
    const Vector5d step = information.ldlt().solve(gradient);
    if (!step.allFinite()) return sigma;
    turn.rotation = turn.rotation * so3_exp(step.head<3>()).toRotationMatrix();
    turn.direction = sphere_retract(turn.direction, step.tail<2>());
    if (step.norm() < kSmallStep) return sigma;
  }
}

}  // namespace

TurnFit fit_turn(std::span<const BearingPair> pairs, double noise,
                 const std::optional<Turn>& start) {
  TurnFit fit;
  if (static_cast<int>(pairs.size()) < kMinPairs) return fit;
  const Turn first = start ? *start : start_without_parallax(pairs, noise);
  fit.turn = first;
  fit.sigma = fit_epipolar(pairs, noise, fit.turn);
  // Not down to the noise: maybe the wrong valley.
  for (const Vector3d& direction : other_directions()) {
    if (fit.sigma < kGoodSpread * noise) break;
    Turn other{first.rotation, direction};
    const double sigma = fit_epipolar(pairs, noise, other);
    if (!(sigma < fit.sigma)) continue;
    fit.turn = other;
    fit.sigma = sigma;
  }
  const Eigen::Matrix<double, 3, 2> basis = sphere_basis(fit.turn.direction);
  for (const BearingPair& pair : pairs)
    fit.num_inliers +=
        std::abs(residual_of(pair, fit.turn, basis).value) < kInlierSigma * fit.sigma;
  return fit;
}

}  // namespace eifmap
