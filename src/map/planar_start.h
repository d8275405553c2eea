// A start before one plane: two motions explain the matches of two views (O. Faugeras, F. Lustman,
// 1988). A third view tells them apart: what the true one makes of the first two fits it, what the
// other makes does not.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geometry/rigid3.h"
#include "geometry/triangulation.h"
#include "map/frame_pair.h"

namespace eifmap {

class PlanarStart {
 public:
  explicit PlanarStart(const MapperOptions& options) : options_(options) {}

  // `pair`: of the anchor and a later frame, its relative pose planar. The first one that shows
  // depth under each of its motions makes the structures, those after it are the third views. Once
  // all of them together leave one motion, the pair gets that one and is planar no more.
  void decide(const ObservedFrame& anchor, const ObservedFrame& newest, FramePair& pair);

 private:
  // Of one motion: the first baseline has length 1.
  struct Structure {
    std::vector<TriangulatedPoint> points;  // by keypoint of the anchor; not valid: none
    Rigid3 newest;                          // in the anchor's frame, of the view before
    double cost = 0;                        // negative log-likelihood of the views so far
  };
  void begin(const ObservedFrame& anchor, const ObservedFrame& newest, const FramePair& pair);
  bool add_view(const ObservedFrame& newest, const FramePair& pair);
  void settle_on(const Structure& structure, const ObservedFrame& anchor,
                 const ObservedFrame& newest, FramePair& pair) const;

  MapperOptions options_;
  std::int64_t anchor_us_ = 0;  // time of the anchor that the structures are of
  int views_ = 0;
  std::vector<Structure> structures_;
};

}  // namespace eifmap
