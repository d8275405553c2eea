#include "place/words.h"

#include <algorithm>
#include <array>
#include <limits>

#include "features/matcher.h"

namespace eifmap {
namespace {

// SplitMix64 (S. Steele et al., OOPSLA 2014).
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : state_(seed) {}
  std::uint64_t below(std::uint64_t n) {  // n > 0; far below 2^64, so that the rest's bias is none
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return (z ^ (z >> 31)) % n;
  }

 private:
  std::uint64_t state_;
};

// Index of an entry, drawn with its weight. Where all are 0 any will do.
std::size_t draw_weighted(const std::vector<int>& weights, Draw& draw) {
  std::uint64_t total = 0;
  for (const int weight : weights) total += static_cast<std::uint64_t>(weight);
  if (total == 0) return draw.below(weights.size());
  std::uint64_t left = draw.below(total);
  std::size_t i = 0;
  while (left >= static_cast<std::uint64_t>(weights[i]))
    left -= static_cast<std::uint64_t>(weights[i++]);
  return i;
}

Words choose_words(std::span<const std::int8_t> descriptors, std::uint64_t seed) {
  const std::size_t count = descriptors.size() / kDescriptorSize;
  Draw draw(seed);
  Words words;
  std::vector<int> distance(count, std::numeric_limits<int>::max()), to_newest(count);
  for (int w = 0; w < kWordsPerSign; ++w) {
    const std::size_t chosen = w == 0 ? draw.below(count) : draw_weighted(distance, draw);
    const auto word = descriptors.subspan(chosen * kDescriptorSize, kDescriptorSize);
    words.insert(words.end(), word.begin(), word.end());
    descriptor_distances(word.data(), descriptors.data(), static_cast<int>(count),
                         to_newest.data());
    for (std::size_t i = 0; i < count; ++i) distance[i] = std::min(distance[i], to_newest[i]);
  }
  return words;
}

int rounded_ratio(int sum, int count) {
  return (2 * sum + (sum < 0 ? -count : count)) / (2 * count);
}

// A word that nothing resembles most stays.
void move_to_middles(std::span<const std::int8_t> descriptors, Words& words) {
  std::vector<int> sum(words.size(), 0), count(kWordsPerSign, 0);
  for (std::size_t i = 0; i < descriptors.size(); i += kDescriptorSize) {
    const int w = nearest_word(&descriptors[i], words);
    ++count[w];
    for (int e = 0; e < kDescriptorSize; ++e) sum[w * kDescriptorSize + e] += descriptors[i + e];
  }
  for (std::size_t e = 0; e < words.size(); ++e)
    if (const int n = count[e / kDescriptorSize]; n > 0)
      words[e] = static_cast<std::int8_t>(rounded_ratio(sum[e], n));
}

}  // namespace

Words learn_words(std::span<const std::int8_t> descriptors, int iterations, std::uint64_t seed) {
  if (descriptors.empty()) return {};
  Words words = choose_words(descriptors, seed);
  for (int i = 0; i < iterations; ++i) move_to_middles(descriptors, words);
  return words;
}

int nearest_word(const std::int8_t* descriptor, const Words& words) {
  std::array<int, kWordsPerSign> distance;
  descriptor_distances(descriptor, words.data(), kWordsPerSign, distance.data());
  return static_cast<int>(std::min_element(distance.begin(), distance.end()) - distance.begin());
}

}  // namespace eifmap
