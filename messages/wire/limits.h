// What is taken from the wire at most: far above what the product makes, low enough that no message
// can cost more than its own bytes are worth.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace eifmap {

inline constexpr std::size_t kMaxMessageBytes = 64u << 20;
inline constexpr int kMaxImageSide = 16384;                     // px
inline constexpr std::size_t kMaxFeatures = 20000;              // of an image
inline constexpr int kMaxFeatureParts = 5000;                   // of a frame; 512 bytes each
inline constexpr std::size_t kMaxDistortion = 5;                // coefficients
inline constexpr std::size_t kMaxText = 4096;                   // characters
inline constexpr std::size_t kMaxEntries = 1u << 20;            // of any other array
inline constexpr int kMaxParts = 1 << 16;                       // of a map update
inline constexpr std::int64_t kMaxTimeUs = 253402300800000000;  // the year 10000

// As much of a text as is taken.
inline std::string clipped(std::string text) {
  if (text.size() > kMaxText) text.resize(kMaxText);
  return text;
}

inline bool valid_time(std::int64_t time_us) {
  return time_us >= 0 && time_us < kMaxTimeUs;
}

// Numbers of frames; -1 none. Sums of thousands of them do not overflow.
inline constexpr std::int64_t kMaxSeq = std::int64_t{1} << 53;

inline bool valid_seq(std::int64_t seq) {
  return seq >= -1 && seq <= kMaxSeq;
}

inline bool valid_image_side(std::int32_t side) {
  return side > 0 && side <= kMaxImageSide;
}

// A unit quaternion, as w x y z, to the precision of what makes them.
inline bool valid_quaternion(const double q[4]) {
  const double norm = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  return std::isfinite(norm) && std::abs(norm - 1) < 1e-6;
}

template <class Number>
bool all_finite(const Number* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (!std::isfinite(values[i])) return false;
  return true;
}

}  // namespace eifmap
