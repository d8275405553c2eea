#include "robustness/corruption.h"

#include <stdexcept>

#include "robustness/choices.h"
#include "robustness/effects.h"

namespace eifmap::test {
namespace {

constexpr CorruptionName kNames[] = {{Corruption::kBlack, "black"},
                                     {Corruption::kNoise, "noise"},
                                     {Corruption::kWrongSize, "wrong_size"},
                                     {Corruption::kShifted, "shifted"},
                                     {Corruption::kHalfCovered, "half_covered"}};

// By 20 to 60 px: further than between two frames of a recording, near enough to look possible.
cv::Point some_shift(Random& random) {
  const double length = random.uniform(20, 60), angle = random.uniform(0, 2 * M_PI);
  return {static_cast<int>(std::lround(length * std::cos(angle))),
          static_cast<int>(std::lround(length * std::sin(angle)))};
}

cv::Mat corrupted(const cv::Mat& good, Corruption kind, Random& random) {
  switch (kind) {
    case Corruption::kBlack:
      return cv::Mat::zeros(good.size(), CV_8U);
    case Corruption::kNoise: {
      cv::RNG noise(random.bits());
      return nothing_but_noise(good.size(), noise);
    }
    case Corruption::kWrongSize:
      return half_size(good);
    case Corruption::kShifted:
      return shifted(good, some_shift(random));
    case Corruption::kHalfCovered: {
      const Half half = static_cast<Half>(random.bits() % 4);
      return half_covered(good, half, static_cast<int>(random.bits() % 256));
    }
  }
  throw std::invalid_argument("no such corruption");
}

}  // namespace

std::span<const CorruptionName> all_corruptions() {
  return kNames;
}

std::vector<Corrupted> write_corrupted(const RecordedSequence& sequence, int frames, int count,
                                       std::span<const Corruption> kinds, Random& random,
                                       OwnFolder& folder) {
  if (kinds.empty()) throw std::invalid_argument("kinds: must be at least one");
  std::vector<Corrupted> strange;
  std::vector<int> counts = between(frames, count, random);
  counts.push_back(0);
  for (int i = 0; i < frames; ++i) {
    folder.add_link(sequence.time_us(i), sequence.image_file(i));
    if (counts[i] == 0) continue;
    const GrayImage good = sequence.load_gray(i);
    if (!good.problem.empty()) throw std::runtime_error(good.problem);
    const std::int64_t step = (sequence.time_us(i + 1) - sequence.time_us(i)) / (counts[i] + 1);
    for (int k = 1; k <= counts[i]; ++k) {
      strange.push_back({sequence.time_us(i) + k * step, kinds[random.bits() % kinds.size()]});
      folder.add(strange.back().time_us, corrupted(good.image, strange.back().kind, random));
    }
  }
  folder.finish(sequence.camera(), timed(sequence.ground_truth()));
  return strange;
}

}  // namespace eifmap::test
