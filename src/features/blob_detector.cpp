#include "features/blob_detector.h"

#include <array>
#include <cstdint>
#include <cstring>

#include "features/box_hessian.h"
#include "features/vector_clones.h"

namespace eifmap {
namespace {

// The samples of one filter on the three rows that matter at a time.
class LevelRows {
 public:
  LevelRows(int lobe, int step, int width, int height)
      : lobe_(lobe), step_(step), width_(width), height_(height) {
    for (std::vector<float>& row : rows_) row.resize(static_cast<std::size_t>(columns()));
  }

  int lobe() const { return lobe_; }
  int columns() const { return (width_ + step_ - 1) / step_; }

  // Computes row j (pixel row j * step), and forgets row j - 3. 0 where the filter leaves the
  // image.
  void compute(const IntegralImage& integral, int j, HessianRow& hessian,
               std::vector<float>& full) {
    std::vector<float>& samples = rows_[static_cast<std::size_t>(j % 3)];
    const int y = j * step_, margin = filter_margin(lobe_);
    if (y < margin || y >= height_ - margin) {
      samples.assign(samples.size(), 0.0f);
    } else if (step_ == 1) {
      hessian.compute(integral, y, lobe_, samples.data());
    } else {
      hessian.compute(integral, y, lobe_, full.data());
      for (std::size_t i = 0; i < samples.size(); ++i)
        samples[i] = full[i * static_cast<std::size_t>(step_)];
    }
  }

  const float* row(int j) const { return rows_[static_cast<std::size_t>(j % 3)].data(); }

 private:
  int lobe_, step_, width_, height_;
  std::array<std::vector<float>, 3> rows_;
};

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
bool is_maximum(const LevelRows& lower, const LevelRows& middle, const LevelRows& upper, int i,
                int j) {
  const float h = middle.row(j)[i];
  for (int dj = -1; dj <= 1; ++dj) {
    const float *finer = lower.row(j + dj), *same = middle.row(j + dj),
                *coarser = upper.row(j + dj);
    for (int di = -1; di <= 1; ++di) {
      if (finer[i + di] >= h || coarser[i + di] > h) return false;
      const bool before = dj < 0 || (dj == 0 && di < 0), itself = dj == 0 && di == 0;
      if (!itself && (before ? same[i + di] >= h : same[i + di] > h)) return false;
    }
  }
  return true;
}

// One octave of filters, swept over the image row by row.
class Octave {
 public:
  // Each octave doubles the step from filter to filter: lobes 3 5 7 9, 5 9 13 17, 9 17 25 33, ...
  // (Bay et al. 2008, fig. 5). The first one starts a lobe finer, with 1: the smallest blobs, sigma
  // below 2 px, are the most numerous and the best located.
  Octave(const IntegralImage& integral, int index, int step, float min_response)
      : integral_(integral),
        step_(step),
        min_response_(min_response),
        full_(static_cast<std::size_t>(integral.width())) {
    const int lobe_step = 2 << index;
    for (int k = index == 0 ? 0 : 1; k <= 4; ++k)
      levels_.emplace_back(1 + k * lobe_step, step, integral.width(), integral.height());
    // Whole words are read below.
    flags_.resize(static_cast<std::size_t>(levels_[0].columns()) + sizeof(std::uint64_t));
  }

  void sweep(std::vector<BlobCandidate>& found) {
    const int rows = (integral_.height() + step_ - 1) / step_;
    for (int j = 0; j < rows; ++j) {
      for (LevelRows& level : levels_) level.compute(integral_, j, hessian_, full_);
      for (std::size_t k = 1; k + 1 < levels_.size(); ++k) find_maxima(k, j - 1, found);
    }
  }

 private:
  // In row j of level k, where the coarser level's filter still fits.
  void find_maxima(std::size_t k, int j, std::vector<BlobCandidate>& found) {
    const LevelRows &lower = levels_[k - 1], &middle = levels_[k], &upper = levels_[k + 1];
    const int border = (filter_margin(upper.lobe()) + step_) / step_ + 1;
    const int end = (integral_.width() - 1) / step_ - border + 1;
    const int end_row = (integral_.height() - 1) / step_ - border + 1;
    if (j < border || j >= end_row || border >= end) return;
    sieve_row(middle.row(j - 1), middle.row(j), middle.row(j + 1), border, end, min_response_,
              flags_.data());
    std::memset(flags_.data() + end, 0, sizeof(std::uint64_t));
    for (int i = border; i < end;) {
      std::uint64_t word;
      std::memcpy(&word, flags_.data() + i, sizeof word);
      if (word == 0) {
        i += static_cast<int>(sizeof word);
        continue;
      }
      if (flags_[static_cast<std::size_t>(i)] && is_maximum(lower, middle, upper, i, j))
        found.push_back(candidate(middle.lobe(), upper.lobe() - middle.lobe(), i, j));
      ++i;
    }
  }

  BlobCandidate candidate(int lobe, int lobe_step, int i, int j) const {
    const int x = i * step_, y = j * step_;
    const BoxHessian hessian = box_hessian_at(integral_, x, y, lobe);
    return {.x = x,
            .y = y,
            .lobe = lobe,
            .lobe_step = lobe_step,
            .response = hessian.determinant(),
            .sign = hessian.trace() < 0 ? -1 : 1};
  }

  const IntegralImage& integral_;
  int step_;
  float min_response_;
  std::vector<LevelRows> levels_;
  HessianRow hessian_;
  std::vector<float> full_;          // a row of the image, before every step-th sample is taken
  std::vector<std::uint8_t> flags_;  // a row of samples
};

}  // namespace

std::vector<BlobCandidate> find_blobs(const IntegralImage& integral, int octaves, int step,
                                      float min_response) {
  std::vector<BlobCandidate> found;
  for (int k = 0; k < octaves; ++k) Octave(integral, k, step << k, min_response).sweep(found);
  return found;
}

}  // namespace eifmap
