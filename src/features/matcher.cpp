#include "features/matcher.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "vector_clones.h"

namespace eifmap {
namespace {

constexpr double kUnit = 254;  // bytes of a unit vector have this norm

constexpr int kLanes = 16;
constexpr int kFar = std::numeric_limits<int>::max();

// The smallest of some distances, whose it is, and the second smallest. Of equal ones, the first is
// the smallest.
struct Nearest {
  int distance = kFar, second = kFar, index = -1;

  void see(const Nearest& other) {
    if (other.distance < distance || (other.distance == distance && other.index < index)) {
      second = std::min(distance, other.second);
      distance = other.distance;
      index = other.index;
    } else {
      second = std::min(second, other.distance);
    }
  }
};

// `count`: a multiple of kLanes.
EIFMAP_VECTOR_CLONES
Nearest nearest_of(const int* __restrict row, int count) {
  alignas(64) int distance[kLanes], second[kLanes], index[kLanes];
  for (int k = 0; k < kLanes; ++k) {
    distance[k] = second[k] = kFar;
    index[k] = -1;
  }
  for (int first = 0; first < count; first += kLanes)
    for (int k = 0; k < kLanes; ++k) {
      const int d = row[first + k];
      const bool nearer = d < distance[k];
      second[k] = std::min(second[k], std::max(d, distance[k]));
      index[k] = nearer ? first + k : index[k];
      distance[k] = std::min(d, distance[k]);
    }
  Nearest nearest;
  for (int k = 0; k < kLanes; ++k) nearest.see({distance[k], second[k], index[k]});
  return nearest;
}

// `smallest` and `index`: per column, of the rows so far.
EIFMAP_VECTOR_CLONES
void see_row(const int* __restrict row, int count, int i, int* __restrict smallest,
             int* __restrict index) {
  for (int k = 0; k < count; ++k) {
    index[k] = row[k] < smallest[k] ? i : index[k];
    smallest[k] = std::min(smallest[k], row[k]);
  }
}

}  // namespace

EIFMAP_VECTOR_CLONES
void descriptor_distances(const std::int8_t* __restrict from, const std::int8_t* __restrict to,
                          int count, int* __restrict result) {
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

int descriptor_distance(const std::int8_t* a, const std::int8_t* b) {
  int distance = 0;
  descriptor_distances(a, b, 1, &distance);
  return distance;
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
  const std::size_t columns = (b.index.size() + kLanes - 1) / kLanes * kLanes;
  std::vector<Nearest> best_of_a(a.index.size());
  std::vector<int> row(columns, kFar), smallest(columns, kFar), best_of_b(columns, -1);
  for (std::size_t i = 0; i < a.index.size(); ++i) {
    descriptor_distances(&a.descriptors[i * kDescriptorSize], b.descriptors.data(), b.size(),
                         row.data());
    best_of_a[i] = nearest_of(row.data(), static_cast<int>(columns));
    see_row(row.data(), b.size(), static_cast<int>(i), smallest.data(), best_of_b.data());
  }
  std::vector<Match> matches;
  for (std::size_t i = 0; i < a.index.size(); ++i) {
    const Nearest& nearest = best_of_a[i];
    if (nearest.index < 0 || nearest.distance > max_squared) continue;
    if (nearest.distance >= ratio_squared * nearest.second) continue;
    const std::size_t k = static_cast<std::size_t>(nearest.index);
    if (options.mutual && best_of_b[k] != static_cast<int>(i)) continue;
    matches.push_back({a.index[i], b.index[k], nearest.distance});
  }
  return matches;
}

}  // namespace eifmap
