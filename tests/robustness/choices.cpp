#include "robustness/choices.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace eifmap::test {
namespace {

// [low, high]
int draw(int low, int high, Random& random) {
  return low + static_cast<int>(random.bits() % static_cast<std::uint64_t>(high - low + 1));
}

}  // namespace

std::vector<int> without_bursts(int n, double share, Random& random) {
  if (!(share >= 0 && share <= 0.5)) throw std::invalid_argument("share: must be in [0, 0.5]");
  const int lost = static_cast<int>(std::lround(share * n)), kept = n - lost;
  std::vector<int> bursts;
  for (int left = lost; left > 0; left -= bursts.back())
    bursts.push_back(std::min(left, draw(2, 8, random)));
  // Each burst after a kept frame of its own: so many of the kept - 1 that have one behind them.
  std::vector<int> frames;
  int frame = 0;
  std::size_t burst = 0;
  for (int k = 0; k < kept; ++k) {
    frames.push_back(frame++);
    const int places = kept - 1 - k, wanted = static_cast<int>(bursts.size() - burst);
    if (places > 0 && random.uniform() * places < wanted) frame += bursts[burst++];
  }
  return frames;
}

std::vector<double> gain_steps(int n, double step, Random& random) {
  std::vector<double> gains;
  double gain = 1;
  while (static_cast<int>(gains.size()) < n) {
    gains.insert(gains.end(), draw(10, 30, random), gain);
    gain = gain != 1 ? 1 : random.bits() % 2 == 0 ? 1 - step : 1 + step;
  }
  gains.resize(n);
  return gains;
}

std::vector<int> between(int n, int count, Random& random) {
  if (n < 2) throw std::invalid_argument("there is no place between fewer than 2 frames");
  std::vector<int> counts(n - 1, 0);
  for (int k = 0; k < count; ++k) ++counts[draw(0, n - 2, random)];
  return counts;
}

}  // namespace eifmap::test
