// Second derivatives of an image by box filters (Bay et al. 2008, 3.2): side 3 * lobe, lobe odd, so
// that every filter is centred on a pixel.
#pragma once

#include <cstdint>
#include <vector>

#include "features/integral_image.h"

namespace eifmap {

constexpr int filter_side(int lobe) {
  return 3 * lobe;
}
// Pixels that the filter reaches beyond its centre.
constexpr int filter_margin(int lobe) {
  return (filter_side(lobe) - 1) / 2;
}
// Sigma of the Gaussian blob to which the filter responds most [measured on rendered ones].
// (The 1.2 px at side 9 of Bay et al. is that of the Gaussian's own shape, and too small.)
constexpr double filter_scale(double lobe) {
  return 0.55 * lobe;
}

// Filter responses of intensities in [0, 1], divided by the filter's area.
struct BoxHessian {
  float xx = 0, yy = 0, xy = 0;

  // 0.9 evens out the box filters' energies (Bay et al. 2008, eq. 3).
  float determinant() const { return xx * yy - 0.81f * (xy * xy); }
  float trace() const { return xx + yy; }
};

// At pixel (x, y), at least filter_margin(lobe) from every border.
BoxHessian box_hessian_at(const IntegralImage& integral, int x, int y, int lobe);

// Sign of Lxx + Lyy where the determinant is positive, and both have the same: -1 bright, +1 dark.
int blob_sign_at(const IntegralImage& integral, int x, int y, int lobe);

// Determinants of a whole row at once.
class HessianRow {
 public:
  // determinants[x] for x in [margin, width - margin), bit for bit those of box_hessian_at; 0
  // outside. y at least the margin from top and bottom. `determinants`: width entries.
  void compute(const IntegralImage& integral, int y, int lobe, float* determinants);

 private:
  std::vector<std::int32_t> xx_, yy_, xy_;  // differences of rows, per column of the integral image
};

}  // namespace eifmap
