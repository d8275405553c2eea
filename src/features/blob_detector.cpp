#include "features/blob_detector.h"

#include <array>
#include <cstdint>
#include <cstring>

#include "features/box_hessian.h"
#include "vector_clones.h"

namespace eifmap {
namespace {

// Rows j - 1, j and j + 1 of a level.
struct ThreeRows {
  const float *above, *here, *below;
};

// largest[i]: the largest sample among the 3x3 around column i, of columns 1 to count - 2.
// `column`: scratch.
EIFMAP_VECTOR_CLONES
void largest_of_nine(const ThreeRows& rows, int count, float* __restrict column,
                     float* __restrict largest) {
  const ThreeRows r = rows;
  const auto larger = [](float x, float y) { return x > y ? x : y; };
  for (int i = 0; i < count; ++i) column[i] = larger(larger(r.above[i], r.here[i]), r.below[i]);
  for (int i = 1; i < count - 1; ++i)
    largest[i] = larger(larger(column[i - 1], column[i]), column[i + 1]);
}

// flags[i] = 1 where the sample is as large as its 3x3x3 neighbours: a sieve in vectors. `finer`,
// `same`, `coarser`: the largest of nine on each level.
EIFMAP_VECTOR_CLONES
void sieve_row(const float* __restrict samples, const float* __restrict finer,
               const float* __restrict same, const float* __restrict coarser, int begin, int end,
               float min_response, std::uint8_t* __restrict flags) {
  for (int i = begin; i < end; ++i) {
    const float h = samples[i];
    flags[i] = static_cast<std::uint8_t>((h > min_response) & (h > finer[i]) & (h >= same[i]) &
                                         (h >= coarser[i]));
  }
}

// Of equal neighbours, the first in the order of levels, rows, columns is the maximum.
bool is_first(const ThreeRows& rows, int i) {
  const float h = rows.here[i];
  return rows.above[i - 1] < h && rows.above[i] < h && rows.above[i + 1] < h &&
         rows.here[i - 1] < h;
}

// The samples of one filter on the three rows that matter at a time.
class LevelRows {
 public:
  // `finer`: the same filter's samples at half the step, if there are any.
  LevelRows(int lobe, int step, int width, int height, const LevelRows* finer)
      : lobe_(lobe), step_(step), width_(width), height_(height), finer_(finer) {
    for (std::vector<float>& row : rows_) row.resize(static_cast<std::size_t>(columns()));
    largest_.resize(static_cast<std::size_t>(columns()));
  }

  int lobe() const { return lobe_; }
  int columns() const { return (width_ + step_ - 1) / step_; }

  // Computes row j (pixel row j * step), and forgets row j - 3. 0 where the filter leaves the
  // image. The finer samples' row 2 j must be there.
  void compute(const IntegralImage& integral, int j, HessianRow& hessian,
               std::vector<float>& full) {
    std::vector<float>& samples = rows_[static_cast<std::size_t>(j % 3)];
    const int y = j * step_, margin = filter_margin(lobe_);
    if (y < margin || y >= height_ - margin) {
      samples.assign(samples.size(), 0.0f);
    } else if (finer_) {
      take_every(2, finer_->row(2 * j), samples);
    } else if (step_ == 1) {
      hessian.compute(integral, y, lobe_, samples.data());
    } else {
      hessian.compute(integral, y, lobe_, full.data());
      take_every(step_, full.data(), samples);
    }
  }

  // Rows j - 1 to j + 1 must be there.
  ThreeRows around(int j) const { return {row(j - 1), row(j), row(j + 1)}; }
  void find_largest(int j, std::vector<float>& scratch) {
    largest_of_nine(around(j), columns(), scratch.data(), largest_.data());
  }

  // The largest sample of the 3x3 around each of the row last asked for.
  const float* largest() const { return largest_.data(); }

 private:
  static void take_every(int step, const float* from, std::vector<float>& samples) {
    for (std::size_t i = 0; i < samples.size(); ++i)
      samples[i] = from[i * static_cast<std::size_t>(step)];
  }

  const float* row(int j) const { return rows_[static_cast<std::size_t>(j % 3)].data(); }

  int lobe_, step_, width_, height_;
  const LevelRows* finer_;
  std::array<std::vector<float>, 3> rows_;
  std::vector<float> largest_;
};

// One octave of filters, swept over the image row by row.
class Octave {
 public:
  // Each octave doubles the step from filter to filter: lobes 3 5 7 9, 5 9 13 17, 9 17 25 33, ...
  // (Bay et al. 2008, fig. 5). The first one starts a lobe finer, with 1: the smallest blobs, sigma
  // below 2 px, are the most numerous and the best located. `finer`: the octave before, of half the
  // step; it stays where it is.
  Octave(const IntegralImage& integral, int index, int step, float min_response,
         const Octave* finer)
      : integral_(integral),
        step_(step),
        min_response_(min_response),
        full_(static_cast<std::size_t>(integral.width())) {
    const int lobe_step = 2 << index;
    for (int k = index == 0 ? 0 : 1; k <= 4; ++k) {
      const int lobe = 1 + k * lobe_step;
      levels_.emplace_back(lobe, step, integral.width(), integral.height(),
                           finer ? finer->level_of(lobe) : nullptr);
    }
    // Whole words are read below.
    flags_.resize(static_cast<std::size_t>(levels_[0].columns()) + sizeof(std::uint64_t));
  }

  // Samples row j, and finds the maxima in the row before. The finer octave is at row 2 j.
  void advance(int j) {
    for (LevelRows& level : levels_) level.compute(integral_, j, hessian_, full_);
    if (j < 2) return;
    for (LevelRows& level : levels_) level.find_largest(j - 1, full_);
    for (std::size_t k = 1; k + 1 < levels_.size(); ++k) find_maxima(k, j - 1);
  }

  const std::vector<BlobCandidate>& found() const { return found_; }

 private:
  const LevelRows* level_of(int lobe) const {
    for (const LevelRows& level : levels_)
      if (level.lobe() == lobe) return &level;
    return nullptr;
  }

  // In row j of level k, where the coarser level's filter still fits.
  void find_maxima(std::size_t k, int j) {
    const LevelRows &lower = levels_[k - 1], &middle = levels_[k], &upper = levels_[k + 1];
    const int border = (filter_margin(upper.lobe()) + step_) / step_ + 1;
    const int end = (integral_.width() - 1) / step_ - border + 1;
    const int end_row = (integral_.height() - 1) / step_ - border + 1;
    if (j < border || j >= end_row || border >= end) return;
    const ThreeRows rows = middle.around(j);
    sieve_row(rows.here, lower.largest(), middle.largest(), upper.largest(), border, end,
              min_response_, flags_.data());
    std::memset(flags_.data() + end, 0, sizeof(std::uint64_t));
    for (int i = border; i < end; i += static_cast<int>(sizeof(std::uint64_t))) {
      std::uint64_t word;
      std::memcpy(&word, flags_.data() + i, sizeof word);
      if (word == 0) continue;
      for (int at = i; at < i + static_cast<int>(sizeof word); ++at)
        if (flags_[static_cast<std::size_t>(at)] && is_first(rows, at))
          found_.push_back({.x = at * step_,
                            .y = j * step_,
                            .lobe = middle.lobe(),
                            .lobe_step = upper.lobe() - middle.lobe(),
                            .response = rows.here[at],
                            .sign = blob_sign_at(integral_, at * step_, j * step_, middle.lobe())});
    }
  }

  const IntegralImage& integral_;
  int step_;
  float min_response_;
  std::vector<LevelRows> levels_;
  HessianRow hessian_;
  std::vector<float> full_;
  std::vector<std::uint8_t> flags_;
  std::vector<BlobCandidate> found_;
};

}  // namespace

std::vector<BlobCandidate> find_blobs(const IntegralImage& integral, int octaves, int step,
                                      float min_response) {
  std::vector<Octave> sweeps;
  sweeps.reserve(static_cast<std::size_t>(octaves));
  for (int k = 0; k < octaves; ++k)
    sweeps.emplace_back(integral, k, step << k, min_response, k > 0 ? &sweeps.back() : nullptr);
  const int rows = (integral.height() + step - 1) / step;
  // All at once: half the filters of an octave are those of the octave before.
  for (int j = 0; j < rows; ++j)
    for (int k = 0; k < octaves && j % (1 << k) == 0; ++k)
      sweeps[static_cast<std::size_t>(k)].advance(j >> k);
  std::vector<BlobCandidate> found;
  for (const Octave& octave : sweeps)
    found.insert(found.end(), octave.found().begin(), octave.found().end());
  return found;
}

}  // namespace eifmap
