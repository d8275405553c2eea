// Gaussian derivatives of the image at a sub-pixel point, up to the sixth order.
#pragma once

#include "features/image_pyramid.h"

namespace eifmap {

// of[j][i]: sigma^(i+j) times the i-th derivative to u and the j-th to v of the image smoothed by a
// Gaussian of that sigma, for i + j <= 6.
struct GaussianDerivatives {
  static constexpr int kOrders = 7;  // 0 to 6
  float of[kOrders][kOrders];
};

// (u, v) inside the image; `sigma` px, >= 1: below, pixels are too coarse. Taken from the level of
// the pyramid on which sigma is 1.4 to 2.8 px.
GaussianDerivatives gaussian_derivatives(const ImagePyramid& pyramid, double u, double v,
                                         double sigma);

}  // namespace eifmap
