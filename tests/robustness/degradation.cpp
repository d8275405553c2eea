#include "robustness/degradation.h"

#include <numeric>
#include <stdexcept>

#include "robustness/choices.h"
#include "robustness/effects.h"

namespace eifmap::test {
namespace {

cv::Mat read(const RecordedSequence& sequence, int i) {
  GrayImage image = sequence.load_gray(i);
  if (!image.problem.empty()) throw std::runtime_error(image.problem);
  return image.image;
}

void write_some(const RecordedSequence& sequence, const std::vector<int>& frames,
                OwnFolder& folder) {
  for (const int i : frames) folder.add_link(sequence.time_us(i), sequence.image_file(i));
  folder.finish(sequence.camera(), timed(sequence.ground_truth()));
}

// effect(image, its number)
template <class Effect>
void write_changed(const RecordedSequence& sequence, const Camera& camera, OwnFolder& folder,
                   const Effect& effect) {
  for (int i = 0; i < sequence.size(); ++i)
    folder.add(sequence.time_us(i), effect(read(sequence, i), i));
  folder.finish(camera, timed(sequence.ground_truth()));
}

void as_recorded(const RecordedSequence& sequence, Random&, OwnFolder& folder) {
  std::vector<int> all(sequence.size());
  std::iota(all.begin(), all.end(), 0);
  write_some(sequence, all, folder);
}

template <int quality>
void jpeg(const RecordedSequence& sequence, Random&, OwnFolder& folder) {
  for (int i = 0; i < sequence.size(); ++i)
    folder.add_jpeg(sequence.time_us(i), as_jpeg(read(sequence, i), quality));
  folder.finish(sequence.camera(), timed(sequence.ground_truth()));
}

void half_the_size(const RecordedSequence& sequence, Random&, OwnFolder& folder) {
  write_changed(sequence, half_size(sequence.camera()), folder,
                [](const cv::Mat& image, int) { return half_size(image); });
}

void half_the_rate(const RecordedSequence& sequence, Random&, OwnFolder& folder) {
  std::vector<int> frames;
  for (int i = 0; i < sequence.size(); i += 2) frames.push_back(i);
  write_some(sequence, frames, folder);
}

void dropped(const RecordedSequence& sequence, Random& random, OwnFolder& folder) {
  write_some(sequence, without_bursts(sequence.size(), 0.1, random), folder);
}

void exposed_anew(const RecordedSequence& sequence, Random& random, OwnFolder& folder) {
  const std::vector<double> gains = gain_steps(sequence.size(), 0.2, random);
  write_changed(sequence, sequence.camera(), folder,
                [&](const cv::Mat& image, int i) { return with_gain(image, gains[i]); });
}

void noisy(const RecordedSequence& sequence, Random& random, OwnFolder& folder) {
  cv::RNG noise(random.bits());
  write_changed(sequence, sequence.camera(), folder,
                [&](const cv::Mat& image, int) { return with_noise(image, 10, noise); });
}

constexpr Degradation kDegradations[] = {
    {"as_recorded", "as recorded", false, &as_recorded},
    {"jpeg80", "JPEG, quality 80", false, &jpeg<80>},
    {"jpeg50", "JPEG, quality 50", false, &jpeg<50>},
    {"half_size", "half the resolution", false, &half_the_size},
    {"half_rate", "half the frame rate", false, &half_the_rate},
    {"bursts", "10 % of the frames dropped, in bursts of 2 to 8", true, &dropped},
    {"gain", "gain steps of 20 % up or down, each for 10 to 30 frames", true, &exposed_anew},
    {"noise", "Gaussian noise, sigma 10 gray levels", true, &noisy},
};

}  // namespace

std::span<const Degradation> all_degradations() {
  return kDegradations;
}

}  // namespace eifmap::test
