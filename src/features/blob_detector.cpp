#include "features/blob_detector.h"

#include <array>
#include <cstdint>
#include <cstring>

#include "features/box_hessian.h"
#include "features/vector_clones.h"

namespace eifmap {
namespace {

// Rows j - 1, j and j + 1 of a level.
struct ThreeRows {
  const float *above, *here, *below;
};

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

  ThreeRows around(int j) const { return {row(j - 1), row(j), row(j + 1)}; }

 private:
  const float* row(int j) const { return rows_[static_cast<std::size_t>(j % 3)].data(); }

  int lobe_, step_, width_, height_;
  std::array<std::vector<float>, 3> rows_;
};

// flags[i] = 1 where the middle level's sample is the maximum among its 3x3x3 neighbours. Of equal
// neighbours, the first in the order of levels, rows, columns is. All in vectors: one by one, most
// of the time goes into guessing wrong which comparison fails.
EIFMAP_VECTOR_CLONES
void mark_maxima(const ThreeRows& lower, const ThreeRows& middle, const ThreeRows& upper, int begin,
                 int end, float min_response, std::uint8_t* __restrict flags) {
  const ThreeRows a = lower, b = middle, c = upper;
  const auto larger = [](float x, float y) { return x > y ? x : y; };
  const auto largest_of_three = [larger](const float* row, int i) {
    return larger(larger(row[i - 1], row[i]), row[i + 1]);
  };
  for (int i = begin; i < end; ++i) {
    const float h = b.here[i];
    const float finer = larger(larger(largest_of_three(a.above, i), largest_of_three(a.here, i)),
                               largest_of_three(a.below, i));
    const float coarser = larger(larger(largest_of_three(c.above, i), largest_of_three(c.here, i)),
                                 largest_of_three(c.below, i));
    const float before = larger(largest_of_three(b.above, i), b.here[i - 1]);
    const float after = larger(largest_of_three(b.below, i), b.here[i + 1]);
    const float must_exceed = larger(larger(finer, before), min_response);
    flags[i] = static_cast<std::uint8_t>((h > must_exceed) & (h >= larger(after, coarser)));
  }
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
    mark_maxima(lower.around(j), middle.around(j), upper.around(j), border, end, min_response_,
                flags_.data());
    std::memset(flags_.data() + end, 0, sizeof(std::uint64_t));
    for (int i = border; i < end; i += static_cast<int>(sizeof(std::uint64_t))) {
      std::uint64_t word;
      std::memcpy(&word, flags_.data() + i, sizeof word);
      if (word == 0) continue;
      for (int at = i; at < i + static_cast<int>(sizeof word); ++at)
        if (flags_[static_cast<std::size_t>(at)])
          found.push_back(candidate(middle.lobe(), upper.lobe() - middle.lobe(), at, j));
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
