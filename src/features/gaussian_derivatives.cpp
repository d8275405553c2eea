#include "features/gaussian_derivatives.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "vector_clones.h"

namespace eifmap {
namespace {

constexpr int kTaps = 24;  // pixels along an axis: whole vectors
constexpr int kCentre = 11;
constexpr int kLanes = 8;
constexpr int kOrders = GaussianDerivatives::kOrders;
constexpr double kFinestSigma = 1.25;  // px, on the levels above the finest

static_assert(kTaps - kCentre <= ImagePyramid::kBorder);

// of[n][k]: weight of the k-th pixel for the n-th derivative.
struct Kernel {
  alignas(32) float of[kOrders][kTaps];
};

// A Gaussian's n-th derivative is a Hermite polynomial times the Gaussian. `fraction`: where the
// point lies right of the pixel kCentre; `sigma` in pixels; `gain`: per order of the derivative.
EIFMAP_VECTOR_CLONES
void make_kernel(float fraction, float sigma, float gain, Kernel& kernel) {
  const float inverse = 1.0f / sigma;
  alignas(32) float x[kTaps];
  for (int k = 0; k < kTaps; ++k) x[k] = (static_cast<float>(k - kCentre) - fraction) * inverse;
  // exp(-x^2 / 2) tap by tap, outward: the ratio of neighbours changes by a constant factor.
  const float factor = std::exp(-inverse * inverse);
  const float half = std::exp(-0.5f * inverse * inverse), tilt = std::exp(x[kCentre] * inverse);
  const float middle = std::exp(-0.5f * x[kCentre] * x[kCentre]) * inverse *
                       static_cast<float>(std::numbers::inv_sqrtpi / std::numbers::sqrt2);
  float value = middle, ratio = half / tilt;
  for (int k = kCentre; k < kTaps; ++k) {
    kernel.of[0][k] = value;
    value *= ratio;
    ratio *= factor;
  }
  value = middle;
  ratio = half * tilt;
  for (int k = kCentre; k >= 0; --k) {
    kernel.of[0][k] = value;
    value *= ratio;
    ratio *= factor;
  }
  for (int k = 0; k < kTaps; ++k) kernel.of[1][k] = gain * x[k] * kernel.of[0][k];
  for (int n = 1; n + 1 < kOrders; ++n) {
    const float before = static_cast<float>(n) * gain * gain;
    for (int k = 0; k < kTaps; ++k)
      kernel.of[n + 1][k] = gain * x[k] * kernel.of[n][k] - before * kernel.of[n - 1][k];
  }
}

// The rows of the pyramid that matter, each from the column of tap 0.
struct Patch {
  int begin = 0, end = 0;  // taps
  const float* rows[kTaps];
};

// A row of taps as vectors: spelled out, so that sums stay in registers.
constexpr int kVectors = kTaps / kLanes;
using Vector [[gnu::vector_size(kLanes * sizeof(float))]] = float;
struct Taps {
  Vector of[kVectors];
};

// Sums down the columns, of kCount derivatives to v from the n-th on.
template <int kCount>
[[gnu::always_inline]] inline void sum_columns(const Patch& patch, const Kernel& along_v, int n,
                                               Taps* columns) {
  Taps sums[kCount] = {};
  for (int j = patch.begin; j < patch.end; ++j) {
    Taps row;
    std::memcpy(&row, patch.rows[j], sizeof row);
    for (int k = 0; k < kCount; ++k)
      for (int b = 0; b < kVectors; ++b) sums[k].of[b] += along_v.of[n + k][j] * row.of[b];
  }
  for (int k = 0; k < kCount; ++k) columns[n + k] = sums[k];
}

// Down the columns, then along the rows.
EIFMAP_VECTOR_CLONES
void apply(const Patch& patch, const Kernel& along_u, const Kernel& along_v,
           GaussianDerivatives& result) {
  Taps columns[kOrders];
  sum_columns<4>(patch, along_v, 0, columns);
  sum_columns<kOrders - 4>(patch, along_v, 4, columns);
  constexpr int kHalf = kLanes / 2, kCount = kOrders * (kOrders + 1) / 2;
  alignas(32) float halves[kCount][kHalf], sums[kCount];
  int count = 0;
  for (int n = 0; n < kOrders; ++n)
    for (int m = 0; n + m < kOrders; ++m) {
      Taps weights;
      std::memcpy(&weights, along_u.of[m], sizeof weights);
      Vector sum = columns[n].of[0] * weights.of[0];
      for (int b = 1; b < kVectors; ++b) sum += columns[n].of[b] * weights.of[b];
      for (int k = 0; k < kHalf; ++k) halves[count][k] = sum[k] + sum[k + kHalf];
      ++count;
    }
  for (int i = 0; i < kCount; ++i)
    sums[i] = (halves[i][0] + halves[i][1]) + (halves[i][2] + halves[i][3]);
  count = 0;
  for (int n = 0; n < kOrders; ++n)
    for (int m = 0; n + m < kOrders; ++m) result.of[n][m] = sums[count++];
}

}  // namespace

GaussianDerivatives gaussian_derivatives(const ImagePyramid& pyramid, double u, double v,
                                         double sigma) {
  int level = 0;
  double size = 1;  // px of the image, of a pixel of the level
  while (level + 1 < pyramid.levels() && sigma >= 2 * kFinestSigma * size) {
    ++level;
    size *= 2;
  }
  const double x = (u + 0.5) / size - 0.5, y = (v + 0.5) / size - 0.5;
  const int column = static_cast<int>(std::lround(x)), row = static_cast<int>(std::lround(y));
  // Taking means has smoothed the level already, by the variance of its pixels on the full grid.
  const double wanted = sigma / size;
  const double kernel_sigma = std::sqrt(wanted * wanted - (1 - 1 / (size * size)) / 4);
  const float gain = static_cast<float>(wanted / kernel_sigma);

  Kernel along_u, along_v;
  make_kernel(static_cast<float>(x - column), static_cast<float>(kernel_sigma), gain, along_u);
  make_kernel(static_cast<float>(y - row), static_cast<float>(kernel_sigma), gain, along_v);
  const int reach = std::min(kCentre, static_cast<int>(4.5 * kernel_sigma) + 1);
  Patch patch{.begin = kCentre - reach, .end = kCentre + reach + 1, .rows = {}};
  for (int j = patch.begin; j < patch.end; ++j)
    patch.rows[j] = pyramid.row(level, row + j - kCentre) + column - kCentre;
  GaussianDerivatives result;
  apply(patch, along_u, along_v, result);
  return result;
}

}  // namespace eifmap
