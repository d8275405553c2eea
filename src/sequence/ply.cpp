#include "sequence/ply.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <vector>

namespace eifmap {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

Rgb colour_of_sign(int sign) {
  return sign < 0 ? Rgb{240, 150, 40} : Rgb{50, 120, 220};
}

// `level` in [0, 1]: blue, green, red.
Rgb colour_of_level(double level) {
  const auto bump = [level](double centre) {
    return static_cast<std::uint8_t>(
        std::lround(255 * std::clamp(1.5 - 4 * std::abs(level - centre), 0.0, 1.0)));
  };
  return {bump(0.85), bump(0.5), bump(0.15)};
}

// The world's y points down: heights are -y. Ends at the 2nd and 98th percentile, so that a stray
// point does not take all the colours.
std::array<double, 2> height_range(std::span<const MapPoint> points) {
  if (points.empty()) return {0, 1};
  std::vector<double> heights;
  for (const MapPoint& point : points) heights.push_back(-point.position.y());
  std::sort(heights.begin(), heights.end());
  const std::size_t low = heights.size() / 50, high = heights.size() - 1 - low;
  return {heights[low], std::max(heights[high], heights[low] + 1e-9)};
}

template <typename T>
void put(std::string& out, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes, bytes + sizeof(T));
  out.append(bytes, sizeof(T));
}

}  // namespace

std::string write_ply(const std::filesystem::path& file, std::span<const MapPoint> points,
                      PlyColour colour) {
  const auto [low, high] = height_range(points);
  std::string data =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(points.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\nproperty int observations\nend_header\n";
  for (const MapPoint& point : points) {
    for (int i = 0; i < 3; ++i) put(data, static_cast<float>(point.position[i]));
    const double level = std::clamp((-point.position.y() - low) / (high - low), 0.0, 1.0);
    const Rgb rgb =
        colour == PlyColour::kSign ? colour_of_sign(point.laplacian_sign) : colour_of_level(level);
    for (std::uint8_t channel : rgb) put(data, channel);
    put(data, static_cast<std::int32_t>(point.num_observations));
  }
  std::ofstream out(file, std::ios::binary);
  out.write(data.data(), static_cast<std::streamsize>(data.size()));
  out.close();
  return out ? "" : file.string() + ": cannot be written";
}

}  // namespace eifmap
