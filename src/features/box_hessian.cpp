#include "features/box_hessian.h"

#include <algorithm>

#include "vector_clones.h"

namespace eifmap {
namespace {

using Sum = std::int32_t;
using Sums = const std::uint32_t* __restrict;

float normalizer(int lobe) {
  const float side = static_cast<float>(filter_side(lobe));
  return 1.0f / (255.0f * side * side);
}

// All box sums of a row share a few rows of the integral image; their differences come first.
struct RowsOfFilter {
  Sums xx_top, xx_bottom;                      // the three boxes of xx stand side by side
  Sums yy_top, yy_upper, yy_lower, yy_bottom;  // those of yy one above the other
  Sums xy_top, xy_upper, xy_lower, xy_bottom;  // a row of pixels lies between upper and lower
};

RowsOfFilter rows_of_filter(const IntegralImage& integral, int y, int lobe) {
  const int half = lobe / 2;
  return {.xx_top = integral.row(y - lobe + 1),
          .xx_bottom = integral.row(y + lobe),
          .yy_top = integral.row(y - lobe - half),
          .yy_upper = integral.row(y - half),
          .yy_lower = integral.row(y + half + 1),
          .yy_bottom = integral.row(y + lobe + half + 1),
          .xy_top = integral.row(y - lobe),
          .xy_upper = integral.row(y),
          .xy_lower = integral.row(y + 1),
          .xy_bottom = integral.row(y + lobe + 1)};
}

EIFMAP_VECTOR_CLONES
void difference_rows(const RowsOfFilter& r, int count, Sum* __restrict xx, Sum* __restrict yy,
                     Sum* __restrict xy) {
  const RowsOfFilter rows = r;
  for (int c = 0; c < count; ++c) {
    xx[c] = static_cast<Sum>(rows.xx_bottom[c] - rows.xx_top[c]);
    yy[c] = static_cast<Sum>(rows.yy_bottom[c] - rows.yy_top[c] -
                             3 * (rows.yy_lower[c] - rows.yy_upper[c]));
    xy[c] = static_cast<Sum>(rows.xy_upper[c] - rows.xy_top[c] -
                             (rows.xy_bottom[c] - rows.xy_lower[c]));
  }
}

// The row differences at the columns that a filter centred on x needs.
EIFMAP_VECTOR_CLONES
void combine_columns(const Sum* __restrict xx, const Sum* __restrict yy, const Sum* __restrict xy,
                     int lobe, float scale, int begin, int end, float* __restrict determinants) {
  const int half = lobe / 2, reach = lobe + half;
  for (int x = begin; x < end; ++x) {
    const Sum sum_xx = xx[x + reach + 1] - xx[x - reach] - 3 * (xx[x + half + 1] - xx[x - half]);
    const Sum sum_yy = yy[x + lobe] - yy[x - lobe + 1];
    const Sum sum_xy = (xy[x] - xy[x - lobe]) - (xy[x + lobe + 1] - xy[x + 1]);
    const float fxx = static_cast<float>(sum_xx) * scale;
    const float fyy = static_cast<float>(sum_yy) * scale;
    const float fxy = static_cast<float>(sum_xy) * scale;
    determinants[x] = fxx * fyy - 0.81f * (fxy * fxy);
  }
}

Sum sum_xx_at(const IntegralImage& integral, int x, int y, int lobe) {
  const int half = lobe / 2, reach = lobe + half;
  const int top = y - lobe + 1, bottom = y + lobe;
  return integral.box(x - reach, top, x + reach + 1, bottom) -
         3 * integral.box(x - half, top, x + half + 1, bottom);
}

}  // namespace

int blob_sign_at(const IntegralImage& integral, int x, int y, int lobe) {
  return sum_xx_at(integral, x, y, lobe) < 0 ? -1 : 1;
}

BoxHessian box_hessian_at(const IntegralImage& integral, int x, int y, int lobe) {
  const int half = lobe / 2, reach = lobe + half;
  const int left = x - lobe + 1, right = x + lobe;
  const Sum xx = sum_xx_at(integral, x, y, lobe);
  const Sum yy = integral.box(left, y - reach, right, y + reach + 1) -
                 3 * integral.box(left, y - half, right, y + half + 1);
  const Sum xy = integral.box(x - lobe, y - lobe, x, y) +
                 integral.box(x + 1, y + 1, x + lobe + 1, y + lobe + 1) -
                 integral.box(x + 1, y - lobe, x + lobe + 1, y) -
                 integral.box(x - lobe, y + 1, x, y + lobe + 1);
  const float scale = normalizer(lobe);
  return {static_cast<float>(xx) * scale, static_cast<float>(yy) * scale,
          static_cast<float>(xy) * scale};
}

void HessianRow::compute(const IntegralImage& integral, int y, int lobe, float* determinants) {
  const int width = integral.width(), margin = filter_margin(lobe);
  const std::size_t count = static_cast<std::size_t>(width) + 1;
  xx_.resize(count);
  yy_.resize(count);
  xy_.resize(count);
  difference_rows(rows_of_filter(integral, y, lobe), width + 1, xx_.data(), yy_.data(), xy_.data());
  const int begin = std::min(margin, width), end = std::max(begin, width - margin);
  std::fill(determinants, determinants + begin, 0.0f);
  combine_columns(xx_.data(), yy_.data(), xy_.data(), lobe, normalizer(lobe), begin, end,
                  determinants);
  std::fill(determinants + end, determinants + width, 0.0f);
}

}  // namespace eifmap
