#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "features/blob_detector.h"
#include "features/box_hessian.h"

namespace eifmap {
namespace {

struct Place {
  int x = 0, y = 0, lobe = 0;
};

bool inside(const IntegralImage& integral, const Place& p, int lobe) {
  const int border = filter_margin(lobe) + 1;
  return p.x >= border && p.y >= border && p.x < integral.width() - border &&
         p.y < integral.height() - border;
}

// Climbs to the largest determinant on the full pixel grid.
bool climb(const IntegralImage& integral, int reach, Place& place, float& response) {
  response = box_hessian_at(integral, place.x, place.y, place.lobe).determinant();
  for (int moves = 0; moves <= reach; ++moves) {
    if (!inside(integral, place, place.lobe)) return false;
    Place best = place;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const float r =
            box_hessian_at(integral, place.x + dx, place.y + dy, place.lobe).determinant();
        if (r > response) {
          response = r;
          best = {place.x + dx, place.y + dy, place.lobe};
        }
      }
    if (best.x == place.x && best.y == place.y) return true;
    place = best;
  }
  return false;
}

}  // namespace

bool refine_blob(const IntegralImage& integral, const BlobCandidate& candidate, Blob& blob) {
  Place place{candidate.x, candidate.y, candidate.lobe};
  const int upper = candidate.lobe + candidate.lobe_step;
  const int lower = candidate.lobe - candidate.lobe_step;
  float response = 0;
  if (!climb(integral, candidate.lobe_step + 1, place, response)) return false;
  if (!inside(integral, place, upper)) return false;

  // Samples d[k][j][i] around the maximum, relative to it.
  double d[3][3][3];
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i)
        d[k][j][i] = box_hessian_at(integral, place.x + i - 1, place.y + j - 1,
                                    k == 0   ? lower
                                    : k == 1 ? place.lobe
                                             : upper)
                             .determinant() /
                         response -
                     1.0;
  const Eigen::Vector3d gradient{(d[1][1][2] - d[1][1][0]) / 2, (d[1][2][1] - d[1][0][1]) / 2,
                                 (d[2][1][1] - d[0][1][1]) / 2};
  Eigen::Matrix3d h;
  h(0, 0) = d[1][1][2] + d[1][1][0];
  h(1, 1) = d[1][2][1] + d[1][0][1];
  h(2, 2) = d[2][1][1] + d[0][1][1];
  h(0, 1) = h(1, 0) = (d[1][2][2] - d[1][2][0] - d[1][0][2] + d[1][0][0]) / 4;
  h(0, 2) = h(2, 0) = (d[2][1][2] - d[2][1][0] - d[0][1][2] + d[0][1][0]) / 4;
  h(1, 2) = h(2, 1) = (d[2][2][1] - d[2][0][1] - d[0][2][1] + d[0][0][1]) / 4;
  const Eigen::Vector3d offset = -h.fullPivLu().solve(gradient);
  if (!offset.allFinite() || offset.cwiseAbs().maxCoeff() > 1.0) return false;
  const BoxHessian hessian = box_hessian_at(integral, place.x, place.y, place.lobe);
  blob.u = static_cast<float>(place.x + offset.x());
  blob.v = static_cast<float>(place.y + offset.y());
  blob.scale = static_cast<float>(filter_scale(place.lobe + offset.z() * candidate.lobe_step));
  blob.response = response;
  blob.sign = hessian.trace() < 0 ? -1 : 1;
  return true;
}

}  // namespace eifmap
