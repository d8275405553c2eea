#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "features/blob_detector.h"
#include "features/box_hessian.h"
#include "features/gaussian_derivatives.h"

namespace eifmap {
namespace {

using Eigen::Matrix2d, Eigen::Matrix3d, Eigen::Vector3d;

constexpr int kMaxIterations = 6;
constexpr double kMaxStep = 0.35;       // of (u / sigma, v / sigma, ln sigma)
constexpr double kGradientStep = 0.25;  // where the function is not concave
constexpr double kGoodStep = 0.05;      // Newton squares it: the next would be no news
constexpr double kLastStep = 0.1;       // beyond this after kMaxIterations, it did not converge
constexpr double kMinScale = 1.0;       // px; below, pixels are too coarse
constexpr double kMaxScaleRatio = 1.6;  // to the candidate's

// A function of (u / sigma, v / sigma, ln sigma) up to the second order.
struct Jet {
  double value = 0;
  Vector3d gradient;
  Matrix3d hessian;
};

// The jet of sigma^2 times the second derivative, i-th to u and j-th to v, i + j = 2. By the heat
// equation, d/d(ln sigma) of sigma^n L is n sigma^n L + sigma^(n+2) (Luu + Lvv).
Jet jet_of(const GaussianDerivatives& d, int i, int j) {
  const auto l = [&d, i, j](int di, int dj) { return static_cast<double>(d.of[j + dj][i + di]); };
  const auto laplacian = [&l](int di, int dj) { return l(di + 2, dj) + l(di, dj + 2); };
  const double by_scale = 2 * l(0, 0) + laplacian(0, 0);
  Jet jet;
  jet.value = l(0, 0);
  jet.gradient = {l(1, 0), l(0, 1), by_scale};
  jet.hessian(0, 0) = l(2, 0);
  jet.hessian(1, 1) = l(0, 2);
  jet.hessian(0, 1) = jet.hessian(1, 0) = l(1, 1);
  jet.hessian(0, 2) = jet.hessian(2, 0) = 2 * l(1, 0) + laplacian(1, 0);
  jet.hessian(1, 2) = jet.hessian(2, 1) = 2 * l(0, 1) + laplacian(0, 1);
  jet.hessian(2, 2) = 2 * by_scale + 4 * laplacian(0, 0) + laplacian(2, 0) + laplacian(0, 2);
  return jet;
}

Jet product(const Jet& a, const Jet& b) {
  return {.value = a.value * b.value,
          .gradient = a.value * b.gradient + b.value * a.gradient,
          .hessian = a.value * b.hessian + b.value * a.hessian +
                     a.gradient * b.gradient.transpose() + b.gradient * a.gradient.transpose()};
}

Jet difference(const Jet& a, const Jet& b) {
  return {.value = a.value - b.value,
          .gradient = a.gradient - b.gradient,
          .hessian = a.hessian - b.hessian};
}

bool concave_in_place(const Matrix3d& h) {
  return h(0, 0) < 0 && h(0, 0) * h(1, 1) - h(0, 1) * h(0, 1) > 0;
}

bool concave(const Matrix3d& h) {
  return concave_in_place(h) && h.determinant() < 0;
}

// Newton's step where there is a maximum to go to; else uphill.
Vector3d step_towards_maximum(const Vector3d& gradient, const Matrix3d& hessian) {
  Vector3d step;
  if (concave(hessian)) {
    step = -hessian.inverse() * gradient;
  } else if (concave_in_place(hessian)) {
    const Matrix2d in_place = hessian.topLeftCorner<2, 2>();
    step.head<2>() = -in_place.inverse() * gradient.head<2>();
    step.z() = hessian(2, 2) < 0 ? -gradient.z() / hessian(2, 2) : std::copysign(0.1, gradient.z());
  } else {
    step = kGradientStep * gradient.stableNormalized();
  }
  const double largest = step.cwiseAbs().maxCoeff();
  return largest > kMaxStep ? Vector3d(step * (kMaxStep / largest)) : step;
}

// Where a parabola through the box filters' responses around the candidate has its top.
Blob start_from_boxes(const IntegralImage& integral, const BlobCandidate& candidate) {
  const int reach = std::max(1, candidate.lobe / 3);
  Blob start{.u = static_cast<double>(candidate.x),
             .v = static_cast<double>(candidate.y),
             .sigma_px = 0,
             .scale = filter_scale(candidate.lobe),
             .response = 0,
             .sign = candidate.sign};
  const int margin = filter_margin(candidate.lobe + candidate.lobe_step) + reach;
  if (candidate.x < margin || candidate.x >= integral.width() - margin || candidate.y < margin ||
      candidate.y >= integral.height() - margin)
    return start;
  const auto response = [&](int i, int j, int k) -> double {
    return box_hessian_at(integral, candidate.x + i * reach, candidate.y + j * reach,
                          candidate.lobe + k * candidate.lobe_step)
        .determinant();
  };
  const double top = response(0, 0, 0);
  const auto vertex = [top](double before, double after) {
    const double curvature = before + after - 2 * top;
    return curvature < 0 ? std::clamp((before - after) / (2 * curvature), -1.0, 1.0) : 0.0;
  };
  start.u += reach * vertex(response(-1, 0, 0), response(1, 0, 0));
  start.v += reach * vertex(response(0, -1, 0), response(0, 1, 0));
  const double k = vertex(response(0, 0, -1), response(0, 0, 1));
  start.scale = std::max(kMinScale, filter_scale(candidate.lobe + k * candidate.lobe_step));
  return start;
}

// Standard deviation of the place, each axis: faint and flat tops move most. Fitted to the errors
// between images and their known homographies, which divided by kFactor's term are alike at every
// scale, response and curvature; kFactor itself to a rendered sequence with parallax, where they
// are 1.4 times as large. kFloor: a camera's own errors.
double sigma_of_place(double scale, const Jet& determinant) {
  constexpr double kFloor = 0.1, kFactor = 0.008, kFlattest = 0.1;
  // Curvature of the top across its flattest direction, with the scale free to follow.
  const Matrix3d h = -determinant.hessian / determinant.value;
  const Matrix2d in_place =
      h.topLeftCorner<2, 2>() - h.block<2, 1>(0, 2) * h.block<1, 2>(2, 0) / h(2, 2);
  const double half_trace = 0.5 * in_place.trace();
  const double spread = std::sqrt(std::max(0.0, half_trace * half_trace - in_place.determinant()));
  const double curvature = std::max(kFlattest, half_trace - spread);
  const double fitted =
      kFactor * std::sqrt(scale) / std::cbrt(determinant.value * curvature * curvature);
  return std::hypot(kFloor, fitted);
}

bool inside(const IntegralImage& integral, const Blob& blob) {
  return blob.u >= 0 && blob.v >= 0 && blob.u <= integral.width() - 1 &&
         blob.v <= integral.height() - 1;
}

}  // namespace

std::optional<Blob> refine_blob(const IntegralImage& integral, const ImagePyramid& pyramid,
                                const BlobCandidate& candidate) {
  const double first_scale = filter_scale(candidate.lobe);
  const double min_scale = std::max(kMinScale, first_scale / kMaxScaleRatio);
  const double max_scale = first_scale * kMaxScaleRatio;
  Blob blob = start_from_boxes(integral, candidate);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const GaussianDerivatives derivatives =
        gaussian_derivatives(pyramid, blob.u, blob.v, blob.scale);
    const Jet uu = jet_of(derivatives, 2, 0), vv = jet_of(derivatives, 0, 2);
    const Jet uv = jet_of(derivatives, 1, 1);
    const Jet determinant = difference(product(uu, vv), product(uv, uv));
    if (!(determinant.value > 0)) return std::nullopt;

    const Vector3d step = step_towards_maximum(determinant.gradient, determinant.hessian);
    const double size = step.cwiseAbs().maxCoeff();
    blob.u += step.x() * blob.scale;
    blob.v += step.y() * blob.scale;
    blob.scale = std::clamp(blob.scale * std::exp(step.z()), min_scale, max_scale);
    blob.response = determinant.value;
    blob.sign = uu.value + vv.value < 0 ? -1 : 1;
    if (!inside(integral, blob)) return std::nullopt;
    const double du = blob.u - candidate.x, dv = blob.v - candidate.y;
    if (du * du + dv * dv > first_scale * first_scale) return std::nullopt;

    const bool last = size < kGoodStep || iteration + 1 == kMaxIterations;
    if (last && size < kLastStep && concave(determinant.hessian)) {
      blob.sigma_px = sigma_of_place(blob.scale, determinant);
      return blob;
    }
  }
  return std::nullopt;
}

}  // namespace eifmap
