// The image around a point, averaged over a grid of square cells of any size at any sub-pixel
// place.
#pragma once

#include "features/integral_image.h"

namespace eifmap {

struct CellGrid {
  static constexpr int kCells = 21;   // per axis; the middle one is centred on the point
  static constexpr int kPadded = 24;  // floats per row: whole vectors, the last ones 0
  alignas(32) float mean[kCells][kPadded] = {};

  // Exact means of the image, each pixel a unit square of constant intensity; the border's pixels
  // go on outside. `side`: px, of a cell, > 0. Means are relative to an arbitrary level: only
  // differences between cells count.
  void sample(const IntegralImage& integral, float u, float v, float side);

  // The same with the grid turned by `angle` (rad, +u towards +v) around the point. The cells'
  // centres turn; the cells themselves stay upright, so that their means remain exact.
  void sample_turned(const IntegralImage& integral, float u, float v, float side, float angle);
};

}  // namespace eifmap
