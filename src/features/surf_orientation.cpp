#include "features/surf_orientation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "features/cell_grid.h"
#include "vector_clones.h"

namespace eifmap {
namespace {

constexpr int kCells = CellGrid::kCells;
constexpr int kPadded = CellGrid::kPadded;
constexpr int kRadius = 6;            // scales, of the disc
constexpr double kWeightSigma = 2.5;  // scales
constexpr int kBins = 72;             // of the circle
constexpr int kWindow = kBins / 6;    // bins in 60 degrees

// Haar responses of four cells' side, centred on the corner between cells (i - 1, j - 1) and (i,
// j).
struct Responses {
  alignas(32) float dx[kCells][kPadded] = {};
  alignas(32) float dy[kCells][kPadded] = {};
};

EIFMAP_VECTOR_CLONES
void haar_responses(const CellGrid& cells, int begin, int end, Responses& responses) {
  alignas(32) float column[kPadded] = {}, tilt[kPadded] = {};
  for (int j = begin; j < end; ++j) {
    const float* row[4] = {cells.mean[j - 2], cells.mean[j - 1], cells.mean[j], cells.mean[j + 1]};
    for (int i = 0; i < kPadded; ++i) {
      column[i] = (row[0][i] + row[1][i]) + (row[2][i] + row[3][i]);
      tilt[i] = (row[2][i] + row[3][i]) - (row[0][i] + row[1][i]);
    }
    for (int i = 2; i < kPadded - 1; ++i) {
      responses.dx[j][i] = (column[i] + column[i + 1]) - (column[i - 2] + column[i - 1]);
      responses.dy[j][i] = (tilt[i - 2] + tilt[i - 1]) + (tilt[i] + tilt[i + 1]);
    }
  }
}

// A sample in the disc and its weight.
struct Sample {
  int i, j;
  float weight;
};

const std::vector<Sample>& disc() {
  static const std::vector<Sample> samples = [] {
    std::vector<Sample> inside;
    for (int j = 0; j <= kCells; ++j)
      for (int i = 0; i <= kCells; ++i) {
        const double x = i - 0.5 * kCells, y = j - 0.5 * kCells;
        const double squared = x * x + y * y;
        if (squared < kRadius * kRadius)
          inside.push_back(
              {i, j, static_cast<float>(std::exp(-0.5 * squared / (kWeightSigma * kWeightSigma)))});
      }
    return inside;
  }();
  return samples;
}

struct Sum {
  float x = 0, y = 0;
  Sum operator+(const Sum& other) const { return {x + other.x, y + other.y}; }
  Sum operator-(const Sum& other) const { return {x - other.x, y - other.y}; }
  float squared() const { return x * x + y * y; }
};

std::array<Sum, kBins> histogram(const Responses& responses) {
  std::array<Sum, kBins> bins{};
  for (const Sample& s : disc()) {
    const Sum response{s.weight * responses.dx[s.j][s.i], s.weight * responses.dy[s.j][s.i]};
    const float turns =
        std::atan2(response.y, response.x) * static_cast<float>(0.5 / std::numbers::pi);
    const int bin = static_cast<int>((turns + 0.5f) * kBins);
    Sum& sum = bins[static_cast<std::size_t>(std::clamp(bin, 0, kBins - 1))];
    sum = sum + response;
  }
  return bins;
}

}  // namespace

float surf_orientation(const IntegralImage& integral, float u, float v, float scale) {
  CellGrid cells;
  cells.sample(integral, u, v, scale);
  Responses responses;
  constexpr int kFirst = kCells / 2 + 1 - kRadius;
  haar_responses(cells, kFirst, kFirst + 2 * kRadius, responses);
  const std::array<Sum, kBins> bins = histogram(responses);
  Sum before[kBins + kWindow + 1];  // of the bins below, around the circle and on
  for (std::size_t k = 0; k < kBins + kWindow; ++k) before[k + 1] = before[k] + bins[k % kBins];
  Sum best;
  for (std::size_t first = 0; first < kBins; ++first) {
    const Sum window = before[first + kWindow] - before[first];
    if (window.squared() > best.squared()) best = window;
  }
  return std::atan2(best.y, best.x);
}

}  // namespace eifmap
