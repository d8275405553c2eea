#include "map/planar_start.h"

#include <algorithm>
#include <cmath>

#include "geometry/projection.h"
#include "geometry/robust.h"
#include "motion/absolute_pose.h"

namespace eifmap {
namespace {

// Log-likelihoods; far beyond chance, because residuals of blobs resemble each other.
constexpr double kAhead = 120;
constexpr int kMinViews = 2;
constexpr int kMaxViews = 60;  // that left it open: a longer first baseline may show more

std::vector<Match> matches_of(const FramePair& pair) {
  std::vector<Match> all = pair.p;
  all.insert(all.end(), pair.m.begin(), pair.m.end());
  return all;
}

std::vector<RelativePoseAlternative> motions_of(const RelativePoseResult& relative) {
  std::vector<RelativePoseAlternative> motions = relative.alternatives;
  motions.insert(motions.begin(), {relative.pose, relative.inlier, relative.num_inliers});
  return motions;
}

double cost_of(const Rigid3& pose, const std::vector<MapObservation>& observations) {
  const Projector camera(pose);
  double cost = 0;
  for (const MapObservation& o : observations) {
    Eigen::Vector2d x;
    const double error = camera(o.point, x) ? (o.x - x).norm() / o.sigma : kBisquare;
    cost += bisquare_cost(std::min(error, kBisquare), kBisquare);
  }
  return cost;
}

// A point's own uncertainty is a part of what its sight may be off.
MapObservation observe_point(const TriangulatedPoint& point, const Rigid3& guess,
                             const Eigen::Vector2d& x, double sigma) {
  MapObservation observation{point.point, x, sigma};
  Eigen::Vector2d predicted;
  Eigen::Matrix<double, 2, 3> d_point;
  if (project(guess, point.point, predicted, nullptr, &d_point))
    observation.sigma =
        std::sqrt(sigma * sigma + (d_point * point.covariance * d_point.transpose()).trace());
  return observation;
}

}  // namespace

void PlanarStart::begin(const ObservedFrame& anchor, const ObservedFrame& newest,
                        const FramePair& pair) {
  structures_.clear();
  views_ = 0;
  anchor_us_ = anchor.frame.time_us;
  const std::vector<Match> matches = matches_of(pair);
  for (const RelativePoseAlternative& motion : motions_of(pair.relative)) {
    Structure structure;
    structure.newest = Rigid3(motion.pose.i_from_j, motion.pose.direction);
    structure.points.resize(static_cast<std::size_t>(anchor.size()));
    int certain = 0;
    for (std::size_t k = 0; k < matches.size(); ++k) {
      const auto [a, b] = std::pair(matches[k].a, matches[k].b);
      if (!motion.inlier[k]) continue;
      const Sighting sightings[] = {{Rigid3(), anchor.x[a], anchor.sigma[a]},
                                    {structure.newest, newest.x[b], newest.sigma[b]}};
      const TriangulatedPoint point = triangulate(sightings);
      if (!point.valid || !(point.relative_depth_sigma < options_.start.max_relative_depth))
        continue;
      structure.points[static_cast<std::size_t>(a)] = point;
      ++certain;
    }
    // One that leaves the points without depth is no motion to start with, whatever it explains.
    if (certain >= options_.start.min_points) structures_.push_back(std::move(structure));
  }
  if (structures_.size() < 2) structures_.clear();
}

bool PlanarStart::add_view(const ObservedFrame& newest, const FramePair& pair) {
  std::vector<Match> shared;  // of points that every structure has
  for (const Match& match : matches_of(pair))
    if (std::all_of(structures_.begin(), structures_.end(), [&](const Structure& s) {
          return s.points[static_cast<std::size_t>(match.a)].valid;
        }))
      shared.push_back(match);
  if (static_cast<int>(shared.size()) < options_.start.min_points / 2) return false;
  for (Structure& structure : structures_) {
    std::vector<MapObservation> observations;
    for (const Match& m : shared)
      observations.push_back(observe_point(structure.points[static_cast<std::size_t>(m.a)],
                                           structure.newest, newest.x[m.b], newest.sigma[m.b]));
    const AbsolutePose pose =
        refine_absolute_pose(structure.newest, observations, options_.absolute_pose);
    structure.newest = pose.world_from_camera;
    structure.cost += cost_of(pose.world_from_camera, observations);
  }
  ++views_;
  return true;
}

void PlanarStart::settle_on(const Structure& structure, const ObservedFrame& anchor,
                            const ObservedFrame& newest, FramePair& pair) const {
  std::vector<Correspondence> all;
  for (const Match& match : matches_of(pair)) all.push_back(correspondence(anchor, newest, match));
  RelativePose pose;
  pose.i_from_j = structure.newest.rotation;
  pose.direction = structure.newest.translation.normalized();
  std::vector<std::uint8_t> inlier;
  if (!refine_relative_pose(all, pose, inlier, options_.relative_pose.covariance)) return;
  // On a plane the refinement may slide towards the other motion.
  constexpr double kStays = 0.1;  // rad
  if (pose.i_from_j.angularDistance(structure.newest.rotation) > kStays ||
      pose.direction.dot(structure.newest.translation.normalized()) < std::cos(kStays))
    return;
  pair.relative.pose = pose;
  pair.relative.num_inliers = static_cast<int>(std::count(inlier.begin(), inlier.end(), 1));
  pair.relative.inlier = std::move(inlier);
  pair.relative.alternatives.clear();
  pair.relative.planar = false;
}

void PlanarStart::decide(const ObservedFrame& anchor, const ObservedFrame& newest,
                         FramePair& pair) {
  if (structures_.empty() || anchor.frame.time_us != anchor_us_ || views_ >= kMaxViews)
    return begin(anchor, newest, pair);
  if (!add_view(newest, pair)) return begin(anchor, newest, pair);
  std::vector<const Structure*> order;
  for (const Structure& structure : structures_) order.push_back(&structure);
  std::sort(order.begin(), order.end(),
            [](const Structure* a, const Structure* b) { return a->cost < b->cost; });
  if (views_ >= kMinViews && order[1]->cost - order[0]->cost > kAhead)
    settle_on(*order[0], anchor, newest, pair);
}

}  // namespace eifmap
