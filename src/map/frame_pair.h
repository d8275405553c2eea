// Two frames matched, and what the matches say of the one's pose in the other: [WD10] Algorithm 1,
// steps 1 and 2.
#pragma once

#include <vector>

#include "map/observed_frame.h"
#include "motion/relative_pose.h"
#include "options.h"

namespace eifmap {

struct FramePair {
  std::vector<Match> p, m;      // of Omega_p and of Omega_m; a: keypoint of i, b: of j
  RelativePoseResult relative;  // of j in i; over p, then m

  int num_matches() const { return static_cast<int>(p.size() + m.size()); }
  // Whether the relative pose explains the k-th match of Omega_m.
  bool explains_m(std::size_t k) const { return relative.inlier[p.size() + k] != 0; }
  // The matches of Omega_p that it explains.
  std::vector<Match> explained_p() const;
};

// The guess may use all matches; what an edge spends is chosen later.
FramePair relate(const ObservedFrame& i, const ObservedFrame& j, double radians_per_pixel,
                 const MapperOptions& options);

}  // namespace eifmap
