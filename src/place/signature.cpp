#include "place/signature.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "vector_clones.h"

namespace eifmap {
namespace {

// `half`: kWordsPerSign * kDescriptorSize bytes, 0.
void describe_sign(const FeatureGroup& features, const Words& words, std::int8_t* half) {
  if (features.size() == 0 || words.empty()) return;
  std::vector<int> sum(words.size(), 0);
  for (std::size_t i = 0; i < features.descriptors.size(); i += kDescriptorSize) {
    const std::int8_t* descriptor = &features.descriptors[i];
    const std::size_t first =
        static_cast<std::size_t>(nearest_word(descriptor, words)) * kDescriptorSize;
    for (std::size_t e = 0; e < kDescriptorSize; ++e)
      sum[first + e] += descriptor[e] - words[first + e];
  }
  std::int64_t length = 0;  // of the vector of square roots, squared
  for (const int s : sum) length += std::abs(s);
  if (length == 0) return;
  for (std::size_t e = 0; e < sum.size(); ++e) {
    const double entry = kSignatureScale * std::sqrt(static_cast<double>(std::abs(sum[e])) /
                                                     static_cast<double>(length));
    const int magnitude = std::min(127, static_cast<int>(entry + 0.5));
    half[e] = static_cast<std::int8_t>(sum[e] < 0 ? -magnitude : magnitude);
  }
}

EIFMAP_VECTOR_CLONES
int inner_product(const std::int8_t* __restrict a, const std::int8_t* __restrict b) {
  int sum = 0;
  for (std::size_t i = 0; i < kSignatureSize; ++i) {
    const short x = a[i], y = b[i];
    sum += x * y;
  }
  return sum;
}

}  // namespace

Signature describe(const SplitFeatures& features, const SplitWords& words) {
  Signature signature{};
  describe_sign(features.minus, words.minus, signature.data());
  describe_sign(features.plus, words.plus, signature.data() + kSignatureSize / 2);
  return signature;
}

int similarity(const Signature& a, const Signature& b) {
  return inner_product(a.data(), b.data());
}

}  // namespace eifmap
