// What an image shows, as one vector: images of the same place have similar ones.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "features/matcher.h"
#include "place/words.h"

namespace eifmap {

// A frame's features by Laplacian sign; the two are never compared ([WD10] II).
struct SplitFeatures {
  FeatureGroup minus, plus;
};
struct SplitWords {
  Words minus, plus;
};

// VLAD (H. Jegou et al., CVPR 2010), of each sign: per word the sum of what the descriptors that
// resemble it most differ from it by, the entries' square roots, scaled to unit length; then times
// kSignatureScale, in bytes. A sign without features or words is 0.
inline constexpr std::size_t kSignatureSize = 2ul * kWordsPerSign * kDescriptorSize;
inline constexpr double kSignatureScale = 400;  // an entry is .02 on average, and hardly ever .3
using Signature = std::array<std::int8_t, kSignatureSize>;

// Sums are of integers, a square root is rounded the same everywhere: so are the bytes.
Signature describe(const SplitFeatures& features, const SplitWords& words);

// The inner product in bytes; that of the same image is 2 * kSignatureScale^2 or nearly so.
int similarity(const Signature& a, const Signature& b);

}  // namespace eifmap
