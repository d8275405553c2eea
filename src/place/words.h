// A handful of descriptors that others are told apart by, learnt from what has been seen so far:
// nothing is read from a file and nothing is trained.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "frame.h"

namespace eifmap {

inline constexpr int kWordsPerSign = 32;

// Of one Laplacian sign: kWordsPerSign descriptors, or none where nothing was to be learnt from.
using Words = std::vector<std::int8_t>;

// From descriptors of kDescriptorSize bytes each. Words are chosen among them, each the more likely
// the less it resembles those chosen before (D. Arthur, S. Vassilvitskii: k-means++, SODA 2007),
// and then moved to the middle of what resembles them, `iterations` times. In integers throughout:
// the same input and seed give the same words everywhere.
Words learn_words(std::span<const std::int8_t> descriptors, int iterations, std::uint64_t seed);

// The word that resembles the descriptor (kDescriptorSize bytes) most; of equal ones the first.
// There must be words.
int nearest_word(const std::int8_t* descriptor, const Words& words);

}  // namespace eifmap
