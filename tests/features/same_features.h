// Features compared to the bit.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "features/features.h"

namespace eifmap::testing {

inline bool same(const Features& a, const Features& b) {
  const auto equal = [](const Keypoint& x, const Keypoint& y) {
    return std::memcmp(&x, &y, offsetof(Keypoint, laplacian_sign)) == 0 &&
           x.laplacian_sign == y.laplacian_sign;
  };
  return a.descriptors == b.descriptors &&
         std::equal(a.keypoints.begin(), a.keypoints.end(), b.keypoints.begin(), b.keypoints.end(),
                    equal);
}

}  // namespace eifmap::testing
