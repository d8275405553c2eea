#include "map/map.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "geometry/robust.h"

namespace eifmap {

Map::Map(const Camera& camera, const MapperOptions& options)
    : radians_per_pixel_(camera.radians_per_pixel()),
      filter_(options.filter, camera.radians_per_pixel()),
      noise_(options) {}

// One for all: of a long run, most keyframes are removed ones.
void Keyframe::forget_seen() {
  static const auto nothing = std::make_shared<const ObservedFrame>();
  frame = nothing;
  track = {};
  spent = {};
}

int Map::add_keyframe(std::shared_ptr<const ObservedFrame> observed,
                      const Rigid3& world_from_camera) {
  places_.add(num_keyframes(), observed->frame);
  Keyframe keyframe;
  keyframe.time_us = observed->frame.time_us;
  keyframe.track.assign(observed->size(), kNoTrack);
  keyframe.spent.assign(observed->size(), 0);
  keyframe.frame = std::move(observed);
  keyframes_.push_back(std::move(keyframe));
  return filter_.add_pose(world_from_camera);
}

void Map::remove_keyframe(int keyframe) {
  constexpr int kOfGauge = 2;
  if (keyframe < kOfGauge || keyframe >= num_keyframes() || is_removed(keyframe))
    throw std::invalid_argument("Map::remove_keyframe: no such keyframe, or of the gauge");
  const std::vector<int> sharing = covisible(keyframe, 2);
  int carrier = sharing.size() > 1 ? sharing[1] : keyframe - 1;
  while (is_removed(carrier)) --carrier;

  const std::vector<int> tracks = keyframes_[keyframe].track;
  for (const int t : tracks) {
    if (t == kNoTrack) continue;
    remove_sight(t, keyframe);
    if (tracks_[t].is_landmark() && tracks_[t].sights.size() < 2) remove_track(t);
  }
  edges_.erase_if([&](const MapEdge& edge) {
    if (edge.i != keyframe && edge.j != keyframe) return false;
    for (const Match& match : edge.matches)
      keyframes_.write(edge.i).spent[match.a] = keyframes_.write(edge.j).spent[match.b] = 0;
    return true;
  });
  for (const FilterAbsolute& absolute : filter_.absolutes()) {
    const AbsoluteObservation& observation = absolute.observation;
    if (observation.is_length() || observation.points.front().pose != keyframe) continue;
    const bool is_down = observation.kind == AbsoluteObservation::Kind::kDown;
    ++scale_.counts.kinds[is_down ? MeasurementKind::kGravity : MeasurementKind::kPosition].dropped;
  }
  filter_.remove_pose(keyframe);
  places_.remove(keyframe);

  Keyframe& old = keyframes_.write(keyframe);
  old.forget_seen();
  old.carrier = carrier;
  old.carrier_from_this = pose(carrier).inverse() * pose(keyframe);
  ++num_removed_;
  for (int k = 0; k < num_keyframes(); ++k) {
    if (keyframes_[k].carrier != keyframe) continue;
    Keyframe& other = keyframes_.write(k);
    other.carrier_from_this = old.carrier_from_this * other.carrier_from_this;
    other.carrier = carrier;
  }
}

int Map::newest() const {
  int k = num_keyframes() - 1;
  while (k > 0 && is_removed(k)) --k;
  return k;
}

void Map::make_metric(double metres_per_unit) {
  filter_.make_metric(metres_per_unit);
  for (int k = 0; k < num_keyframes(); ++k)
    if (is_removed(k)) keyframes_.write(k).carrier_from_this.translation *= metres_per_unit;
}

std::vector<double> Map::bend(const std::vector<Similarity>& world_from_keyframe) {
  if (world_from_keyframe.size() != keyframes_.size())
    throw std::invalid_argument("Map::bend: not of all keyframes");
  for (const Similarity& s : world_from_keyframe)
    if (!(s.scale > 0)) throw std::invalid_argument("Map::bend: a scale is not positive");
  std::vector<Rigid3> poses{pose(0)};
  for (int k = 1; k < num_keyframes(); ++k) poses.push_back(world_from_keyframe[k].rigid());
  std::vector<std::pair<int, Eigen::Vector3d>> positions;
  for (const Track& track : tracks_) {
    if (!track.is_landmark()) continue;
    const int k = track.sights[track.sights.size() / 2].keyframe;
    const Eigen::Vector3d in_keyframe = pose(k).inverse() * filter_.position(track.landmark);
    positions.emplace_back(track.landmark, world_from_keyframe[k] * in_keyframe);
  }
  filter_.move(poses, positions);
  std::vector<double> growth;
  for (int k = 0; k < num_keyframes(); ++k)
    growth.push_back(world_from_keyframe[is_removed(k) ? keyframes_[k].carrier : k].scale);
  const auto grow = [&growth](PlacedMeasurement& m) {
    for (PlacedPoint& point : m.points) point.grow(growth[point.keyframe]);
  };
  for (PlacedMeasurement& m : scale_.waiting) grow(m);
  for (PlacedMeasurement& m : scale_.contradicting) grow(m);
  for (int k = 0; k < num_keyframes(); ++k)
    if (is_removed(k)) keyframes_.write(k).carrier_from_this.translation *= growth[k];
  carry_removed();
  ++num_bends_;
  return growth;
}

void Map::carry_removed() {
  if (num_removed_ == 0) return;
  for (int k = 0; k < num_keyframes(); ++k)
    if (is_removed(k))
      filter_.carry(k, pose(keyframes_[k].carrier) * keyframes_[k].carrier_from_this);
}

int Map::add_track(const Sight& sight) {
  tracks_.push_back({});
  const int track = num_tracks() - 1;
  add_sight(track, sight);
  return track;
}

bool Map::add_sight(int track, const Sight& seen) {
  const Sight sight = seen;  // it may be another track's, in a piece that is written to
  if (keyframes_.at(sight.keyframe).track.at(sight.keypoint) != kNoTrack) return false;
  const std::vector<Sight>& sights = tracks_.at(track).sights;
  const auto place = std::lower_bound(sights.begin(), sights.end(), sight.keyframe,
                                      [](const Sight& s, int k) { return s.keyframe < k; });
  if (place != sights.end() && place->keyframe == sight.keyframe) return false;
  const auto at = place - sights.begin();
  Track& t = tracks_.write(track);
  t.sights.insert(t.sights.begin() + at, sight);
  keyframes_.write(sight.keyframe).track[sight.keypoint] = track;
  if (t.is_landmark()) add_measurement(t.landmark, sight);
  return true;
}

void Map::add_measurement(int landmark, const Sight& sight) {
  const ObservedFrame& observed = keyframes_[sight.keyframe].observed();
  filter_.add_measurement(
      landmark, sight.keyframe, observed.x[sight.keypoint],
      observed.sigma[sight.keypoint] * (sigma_factor() / observed.sigma_factor));
}

void Map::remove_sight(int track, int keyframe) {
  if (track < 0 || track >= num_tracks()) throw std::out_of_range("Map: no such track");
  Track& t = tracks_.write(track);
  std::erase_if(t.sights, [&](const Sight& s) {
    if (s.keyframe != keyframe) return false;
    keyframes_.write(keyframe).track[s.keypoint] = kNoTrack;
    return true;
  });
  if (t.is_landmark())
    filter_.remove_measurement(t.landmark, keyframe);
  else if (t.sights.empty())
    tracks_.reset(track);
}

std::vector<int> Map::measured_tracks() const {
  std::vector<int> tracks;
  for (const FilterAbsolute& absolute : filter_.absolutes())
    if (absolute.observation.kind == AbsoluteObservation::Kind::kLandmarks)
      for (int landmark : absolute.observation.landmarks)
        tracks.push_back(track_of_landmark_[landmark]);
  std::sort(tracks.begin(), tracks.end());
  tracks.erase(std::unique(tracks.begin(), tracks.end()), tracks.end());
  return tracks;
}

void Map::remove_track(int track) {
  if (track < 0 || track >= num_tracks()) throw std::out_of_range("Map: no such track");
  Track& t = tracks_.write(track);
  for (const Sight& s : t.sights) keyframes_.write(s.keyframe).track[s.keypoint] = kNoTrack;
  const int landmark = t.landmark;
  tracks_.reset(track);  // its number stays, and there may be many such
  if (landmark < 0) return;
  if (const int distances = filter_.num_distances(landmark); distances > 0)
    scale_.counts.kinds[MeasurementKind::kLandmarks].dropped += distances;
  filter_.remove_landmark(landmark);
  --num_landmarks_;
}

bool Map::join_tracks(int kept, int gone) {
  const std::vector<Sight> sights = tracks_.at(gone).sights;
  const std::vector<Sight>& others = tracks_.at(kept).sights;
  const auto is_seen = [&](const Sight& sight) {
    return std::any_of(others.begin(), others.end(),
                       [&](const Sight& s) { return s.keyframe == sight.keyframe; });
  };
  if (kept == gone || std::any_of(sights.begin(), sights.end(), is_seen)) return false;
  // A measured distance would go with it.
  const Track& leaving = tracks_[gone];
  if (leaving.is_landmark() && filter_.num_distances(leaving.landmark) > 0) return false;
  remove_track(gone);
  for (const Sight& sight : sights) add_sight(kept, sight);
  return true;
}

void Map::promote(int track, const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance) {
  if (tracks_.at(track).is_landmark())
    throw std::invalid_argument("Map::promote: a landmark already");
  Track& t = tracks_.write(track);
  t.landmark = filter_.add_landmark(position, covariance);
  track_of_landmark_.push_back(track);
  ++num_landmarks_;
  for (const Sight& s : t.sights) add_measurement(t.landmark, s);
}

void Map::spend(MapEdge edge) {
  if (std::min(edge.i, edge.j) < 0 || std::max(edge.i, edge.j) >= num_keyframes())
    throw std::out_of_range("Map: no such keyframe");
  for (const Match& match : edge.matches) {
    keyframes_.write(edge.i).spent.at(match.a) = 1;
    keyframes_.write(edge.j).spent.at(match.b) = 1;
  }
  edges_.push_back(std::move(edge));
}

FilterUpdate Map::update() {
  FilterUpdate update = filter_.update();
  // Covariances stay of the old sigmas until the next keyframe's update. One at once would drop
  // what does not fit twice by one keyframe's evidence: at every 10th image of a recording one of
  // six runs then ended at twice the error, and one lost 7 of its 100 images.
  if (const double change = noise_.follow(update); change != 1) filter_.scale_sigmas(change);
  for (const FilterUpdate::Dropped& dropped : update.dropped) {
    const int track = track_of_landmark_[dropped.landmark];
    remove_sight(track, dropped.pose);
    if (tracks_[track].is_landmark() && tracks_[track].sights.size() < 2) remove_track(track);
  }
  carry_removed();
  return update;
}

std::vector<int> Map::num_shared(int keyframe) const {
  std::vector<int> shared(num_keyframes(), 0);
  for (int t : keyframes_[keyframe].track)
    if (t != kNoTrack && tracks_[t].is_landmark())
      for (const Sight& s : tracks_[t].sights) ++shared[s.keyframe];
  shared[keyframe] = 0;
  return shared;
}

std::vector<int> Map::covisible(int keyframe, int count) const {
  const std::vector<int> shared = num_shared(keyframe);
  std::vector<int> order;
  for (int k = 0; k < num_keyframes(); ++k)
    if (shared[k] > 0) order.push_back(k);
  std::sort(order.begin(), order.end(), [&shared](int a, int b) {
    return shared[a] != shared[b] ? shared[a] > shared[b] : a > b;
  });
  order.insert(order.begin(), keyframe);
  if (static_cast<int>(order.size()) > count) order.resize(count);
  return order;
}

std::vector<int> Map::landmarks_of(const std::vector<int>& keyframes) const {
  std::vector<int> found;
  for (int k : keyframes)
    for (int t : keyframes_[k].track)
      if (t != kNoTrack && tracks_[t].is_landmark()) found.push_back(t);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::vector<double> Map::depths(int keyframe) const {
  std::vector<double> depths;
  const Rigid3 camera_from_world = pose(keyframe).inverse();
  for (int t : keyframes_[keyframe].track)
    if (t != kNoTrack && tracks_[t].is_landmark())
      depths.push_back((camera_from_world * position(t)).z());
  return depths;
}

double Map::median_depth(int keyframe) const {
  std::vector<double> all = depths(keyframe);
  return take_median(all);
}

}  // namespace eifmap
