#include "features/matcher.h"

#include <cstddef>
#include <limits>

#include "features/vector_clones.h"

namespace eifmap {
namespace {

constexpr double kUnit = 254;  // bytes of a unit vector have this norm

// The two smallest distances seen, and whose the smallest is.
struct Nearest {
  int distance = std::numeric_limits<int>::max();
  int second = std::numeric_limits<int>::max();
  int index = -1;

  void see(int d, int i) {
    if (d < distance) {
      second = distance;
      distance = d;
      index = i;
    } else if (d < second) {
      second = d;
    }
  }
};

int distance_of(const std::int8_t* __restrict a, const std::int8_t* __restrict b) {
  int sum = 0;
  for (int i = 0; i < kDescriptorSize; ++i) {
    const int d = a[i] - b[i];
    sum += d * d;
  }
  return sum;
}

EIFMAP_VECTOR_CLONES
void distances(const std::int8_t* __restrict from, const std::int8_t* __restrict to, int count,
               int* __restrict result) {
  for (int k = 0; k < count; ++k) {
    const std::int8_t* b = to + std::ptrdiff_t{kDescriptorSize} * k;
    int sum = 0;
    for (int i = 0; i < kDescriptorSize; ++i) {
      const short d = static_cast<short>(from[i] - b[i]);
      sum += d * d;
    }
    result[k] = sum;
  }
}

}  // namespace

int descriptor_distance(const std::int8_t* a, const std::int8_t* b) {
  return distance_of(a, b);
}

FeatureGroup features_of_sign(const FeatureFrame& frame, int laplacian_sign) {
  FeatureGroup group;
  for (std::size_t i = 0; i < frame.keypoints.size(); ++i) {
    if (frame.keypoints[i].laplacian_sign != laplacian_sign) continue;
    group.index.push_back(static_cast<int>(i));
    const auto first = frame.descriptors.begin() + static_cast<std::ptrdiff_t>(i * kDescriptorSize);
    group.descriptors.insert(group.descriptors.end(), first, first + kDescriptorSize);
  }
  return group;
}

std::string MatchOptions::problem() const {
  const auto wrong = [](const char* field, double value, const char* right) {
    return std::string("match.") + field + " is " + std::to_string(value) + ": must be " + right;
  };
  if (!(max_ratio > 0 && max_ratio <= 1)) return wrong("max_ratio", max_ratio, "in (0, 1]");
  if (!(max_distance > 0 && max_distance <= 2))
    return wrong("max_distance", max_distance, "in (0, 2]");
  return "";
}

std::vector<Match> match(const FeatureGroup& a, const FeatureGroup& b,
                         const MatchOptions& options) {
  const double max_squared = options.max_distance * options.max_distance * kUnit * kUnit;
  const double ratio_squared = options.max_ratio * options.max_ratio;
  std::vector<Nearest> best_of_a(a.index.size()), best_of_b(b.index.size());
  std::vector<int> row(b.index.size());
  for (std::size_t i = 0; i < a.index.size(); ++i) {
    distances(&a.descriptors[i * kDescriptorSize], b.descriptors.data(), b.size(), row.data());
    for (std::size_t k = 0; k < row.size(); ++k) {
      best_of_a[i].see(row[k], static_cast<int>(k));
      best_of_b[k].see(row[k], static_cast<int>(i));
    }
  }
  std::vector<Match> matches;
  for (std::size_t i = 0; i < a.index.size(); ++i) {
    const Nearest& nearest = best_of_a[i];
    if (nearest.index < 0 || nearest.distance > max_squared) continue;
    if (nearest.distance >= ratio_squared * nearest.second) continue;
    const std::size_t k = static_cast<std::size_t>(nearest.index);
    if (options.mutual && best_of_b[k].index != static_cast<int>(i)) continue;
    matches.push_back({a.index[i], b.index[k], nearest.distance});
  }
  return matches;
}

}  // namespace eifmap
