#include "features/blob_detector.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "features/box_hessian.h"
#include "features/vector_clones.h"

namespace eifmap {
namespace {

constexpr int kLevels = 4;  // per octave; maxima are sought in the two in the middle

// Determinants on a grid; sample (i, j) belongs to pixel (i * step, j * step).
struct Level {
  int lobe = 0, step = 1, columns = 0, rows = 0;
  std::vector<float> determinants;  // row-major; 0 where the filter leaves the image
  const float* row(int j) const {
    return determinants.data() + static_cast<std::size_t>(j) * static_cast<std::size_t>(columns);
  }
  float* row(int j) {
    return determinants.data() + static_cast<std::size_t>(j) * static_cast<std::size_t>(columns);
  }
};

using Octave = std::array<Level, kLevels>;

// Lobes 3 5 7 9, 5 9 13 17, 9 17 25 33, ...: each octave doubles the step (Bay et al. 2008, fig.
// 5).
int octave_lobe_step(int octave) {
  return 2 << octave;
}
int octave_lobe(int octave, int level) {
  return 1 + (level + 1) * octave_lobe_step(octave);
}

Level empty_level(const IntegralImage& integral, int lobe, int step) {
  Level level{.lobe = lobe,
              .step = step,
              .columns = (integral.width() + step - 1) / step,
              .rows = (integral.height() + step - 1) / step,
              .determinants = {}};
  level.determinants.resize(static_cast<std::size_t>(level.columns) *
                            static_cast<std::size_t>(level.rows));
  return level;
}

Level computed_level(const IntegralImage& integral, int lobe, int step) {
  Level level = empty_level(integral, lobe, step);
  const int margin = filter_margin(lobe);
  HessianRow hessian;
  std::vector<float> full(static_cast<std::size_t>(integral.width()));
  for (int j = (margin + step - 1) / step; j * step < integral.height() - margin; ++j) {
    if (step == 1) {
      hessian.compute(integral, j, lobe, level.row(j));
      continue;
    }
    hessian.compute(integral, j * step, lobe, full.data());
    float* samples = level.row(j);
    for (int i = 0; i < level.columns; ++i) samples[i] = full[static_cast<std::size_t>(i * step)];
  }
  return level;
}

// Every second sample of every second row.
Level halved_level(const IntegralImage& integral, const Level& fine) {
  Level level = empty_level(integral, fine.lobe, 2 * fine.step);
  for (int j = 0; j < level.rows; ++j) {
    const float* from = fine.row(2 * j);
    float* to = level.row(j);
    for (int i = 0; i < level.columns; ++i) to[i] = from[2 * i];
  }
  return level;
}

Octave first_octave(const IntegralImage& integral, int step) {
  Octave octave;
  for (int k = 0; k < kLevels; ++k)
    octave[static_cast<std::size_t>(k)] = computed_level(integral, octave_lobe(0, k), step);
  return octave;
}

// Two of the four filters were in the finer octave already.
Octave next_octave(const IntegralImage& integral, const Octave& finer, int index) {
  const int step = 2 * finer[0].step;
  return {halved_level(integral, finer[1]), halved_level(integral, finer[3]),
          computed_level(integral, octave_lobe(index, 2), step),
          computed_level(integral, octave_lobe(index, 3), step)};
}

// flags[i] = 1 where the sample stands out in its row and column: a cheap sieve, in vectors.
EIFMAP_VECTOR_CLONES
void sieve_row(const float* __restrict above, const float* __restrict here,
               const float* __restrict below, int begin, int end, float min_response,
               std::uint8_t* __restrict flags) {
  for (int i = begin; i < end; ++i) {
    const float h = here[i];
    flags[i] = static_cast<std::uint8_t>((h > min_response) & (h > above[i]) & (h > here[i - 1]) &
                                         (h >= here[i + 1]) & (h >= below[i]));
  }
}

// Of equal neighbours, the first in the order of levels, rows, columns is the maximum.
bool is_maximum(const Level& lower, const Level& middle, const Level& upper, int i, int j) {
  const float h = middle.row(j)[i];
  for (int dj = -1; dj <= 1; ++dj) {
    const float *below = lower.row(j + dj), *same = middle.row(j + dj), *above = upper.row(j + dj);
    for (int di = -1; di <= 1; ++di) {
      if (below[i + di] >= h || above[i + di] > h) return false;
      const bool before = dj < 0 || (dj == 0 && di < 0), itself = dj == 0 && di == 0;
      if (!itself && (before ? same[i + di] >= h : same[i + di] > h)) return false;
    }
  }
  return true;
}

void find_maxima(const IntegralImage& integral, const Octave& octave, std::size_t k,
                 float min_response, std::vector<BlobCandidate>& found) {
  const Level &lower = octave[k - 1], &middle = octave[k], &upper = octave[k + 1];
  const int step = middle.step;
  const int border = (filter_margin(upper.lobe) + step) / step + 1;
  const int end = (integral.width() - 1) / step - border + 1;
  const int end_row = (integral.height() - 1) / step - border + 1;
  std::vector<std::uint8_t> flags(static_cast<std::size_t>(middle.columns));
  for (int j = border; j < end_row; ++j) {
    sieve_row(middle.row(j - 1), middle.row(j), middle.row(j + 1), border, end, min_response,
              flags.data());
    for (int i = border; i < end; ++i) {
      if (!flags[static_cast<std::size_t>(i)] || !is_maximum(lower, middle, upper, i, j)) continue;
      const int x = i * step, y = j * step;
      const BoxHessian hessian = box_hessian_at(integral, x, y, middle.lobe);
      found.push_back({.x = x,
                       .y = y,
                       .lobe = middle.lobe,
                       .lobe_step = upper.lobe - middle.lobe,
                       .response = middle.row(j)[i],
                       .sign = hessian.trace() < 0 ? -1 : 1});
    }
  }
}

}  // namespace

std::vector<BlobCandidate> find_blobs(const IntegralImage& integral, int octaves, int step,
                                      float min_response) {
  std::vector<BlobCandidate> found;
  Octave octave = first_octave(integral, step);
  for (int o = 0; o < octaves; ++o) {
    if (o > 0) octave = next_octave(integral, octave, o);
    for (std::size_t k = 1; k + 1 < kLevels; ++k)
      find_maxima(integral, octave, k, min_response, found);
  }
  return found;
}

}  // namespace eifmap
