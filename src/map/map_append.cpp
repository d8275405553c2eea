// Another map's keyframes, tracks and edges in this one.
#include <stdexcept>
#include <utility>

#include "map/map.h"

namespace eifmap {

bool Map::is_measured() const {
  return filter_.is_metric() || filter_.has_level() || !filter_.absolutes().empty() ||
         !scale_.waiting.empty() || !scale_.contradicting.empty();
}

Appended Map::append(const Map& other, const Similarity& world_from_other) {
  if (!(world_from_other.scale > 0) || !world_from_other.translation.allFinite() ||
      !world_from_other.rotation.allFinite())
    throw std::invalid_argument("Map::append: no similarity");
  if (other.is_measured() || num_keyframes() == 0 || other.num_keyframes() == 0 ||
      map_sign() != other.map_sign())
    throw std::invalid_argument("Map::append: measured, empty, or of another sign");
  const Appended appended{num_keyframes(), num_tracks(), world_from_other.scale};
  if (const double change = noise_.include(other.noise_); change != 1) filter_.scale_sigmas(change);
  append_keyframes(other, world_from_other);
  append_tracks(other, world_from_other, appended.first_keyframe);
  append_edges(other, appended.first_keyframe);
  scale_.counts += other.scale_.counts;
  num_bends_ += other.num_bends_ + 1;
  return appended;
}

void Map::append_keyframes(const Map& other, const Similarity& world_from_other) {
  const int first = num_keyframes();
  for (int k = 0; k < other.num_keyframes(); ++k) {
    const Keyframe& from = other.keyframes_[k];
    const Rigid3 pose = (world_from_other * Similarity::of(other.pose(k))).rigid();
    if (!from.removed()) {
      add_keyframe(from.frame, pose);
      keyframes_.write_back().spent = from.spent;
      continue;
    }
    Keyframe removed = from;
    removed.carrier += first;
    removed.carrier_from_this.translation *= world_from_other.scale;
    keyframes_.push_back(std::move(removed));
    filter_.remove_pose(filter_.add_pose(pose));
    ++num_removed_;
  }
  carry_removed();
}

// Also such as are no more: each keeps its distance to the first.
void Map::append_tracks(const Map& other, const Similarity& world_from_other, int first_keyframe) {
  const double squared = world_from_other.scale * world_from_other.scale;
  for (int t = 0; t < other.num_tracks(); ++t) {
    const Track& from = other.tracks_[t];
    const int track = num_tracks();
    tracks_.push_back({});
    if (from.sights.empty()) tracks_.reset(track);
    for (const Sight& s : from.sights) add_sight(track, {first_keyframe + s.keyframe, s.keypoint});
    if (from.is_landmark())
      promote(track, world_from_other * other.position(t),
              squared * world_from_other.rotation * other.position_covariance(t) *
                  world_from_other.rotation.transpose());
  }
}

void Map::append_edges(const Map& other, int first_keyframe) {
  for (const FilterEdge& edge : other.filter_.edges()) {
    RelativePoseMeasurement measurement = edge.measurement;
    measurement.sqrt_information *= other.sigma_factor() / sigma_factor();
    filter_.add_edge(first_keyframe + edge.i, first_keyframe + edge.j, measurement);
  }
  for (MapEdge edge : other.edges_) {
    edge.i += first_keyframe;
    edge.j += first_keyframe;
    edges_.push_back(std::move(edge));
  }
}

}  // namespace eifmap
