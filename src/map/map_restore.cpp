// A map as it was, from what a file keeps of it.
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "map/map_contents.h"

namespace eifmap {
namespace {

bool is_pose(const Rigid3& pose) {
  return pose.translation.allFinite() && std::abs(pose.rotation.norm() - 1) < 1e-6;
}

// Of an enumeration that counts from 0.
template <class Enum>
bool is_one_of(Enum value, Enum last) {
  const auto number = static_cast<int>(value);
  return number >= 0 && number <= static_cast<int>(last);
}

std::string of(const char* what, std::size_t number, const char* problem) {
  return std::string(what) + " " + std::to_string(number) + " " + problem;
}

class Checker {
 public:
  explicit Checker(const MapContents& contents) : contents_(contents) {}

  std::string problem() const {
    if (contents_.keyframes.size() < 2) return "it has less than two keyframes";
    for (auto check : {&Checker::keyframes, &Checker::tracks, &Checker::edges,
                       &Checker::measurements, &Checker::rest})
      if (std::string problem = (this->*check)(); !problem.empty()) return problem;
    return "";
  }

 private:
  bool in_use(int keyframe) const {
    return keyframe >= 0 && keyframe < static_cast<int>(contents_.keyframes.size()) &&
           contents_.keyframes[keyframe].carrier < 0;
  }
  bool has_keypoint(int keyframe, int keypoint) const {
    return in_use(keyframe) && keypoint >= 0 &&
           keypoint < contents_.keyframes[keyframe].frame->size();
  }
  bool has_landmark(int track) const {
    const auto found = std::lower_bound(
        contents_.tracks.begin(), contents_.tracks.end(), track,
        [](const MapContents::OfTrack& of, int number) { return of.number < number; });
    return found != contents_.tracks.end() && found->number == track && found->is_landmark;
  }

  std::string keyframes() const {
    for (std::size_t k = 0; k < contents_.keyframes.size(); ++k) {
      const MapContents::OfKeyframe& keyframe = contents_.keyframes[k];
      if (!is_pose(keyframe.pose)) return of("keyframe", k, "has no pose");
      if (keyframe.carrier < 0 && !keyframe.frame) return of("keyframe", k, "has no image");
      if (keyframe.carrier >= 0 && k < 2) return of("keyframe", k, "is of the gauge and removed");
    }
    for (std::size_t k = 0; k < contents_.keyframes.size(); ++k) {
      const MapContents::OfKeyframe& keyframe = contents_.keyframes[k];
      if (keyframe.carrier < 0) continue;
      if (!in_use(keyframe.carrier) || !is_pose(keyframe.carrier_from_this))
        return of("keyframe", k, "is removed and nothing carries it");
    }
    return "";
  }

  std::string tracks() const {
    std::vector<std::vector<std::uint8_t>> taken;  // keypoints, by keyframe
    for (const MapContents::OfKeyframe& keyframe : contents_.keyframes)
      taken.emplace_back(keyframe.frame ? keyframe.frame->size() : 0, 0);
    int next = 0;
    for (const MapContents::OfTrack& track : contents_.tracks) {
      const auto t = static_cast<std::size_t>(track.number);
      if (track.number < next || track.number >= contents_.num_tracks || track.sights.empty())
        return of("track", t, "is out of order, or was never seen");
      next = track.number + 1;
      int last = -1;
      for (const Sight& sight : track.sights) {
        if (!has_keypoint(sight.keyframe, sight.keypoint))
          return of("track", t, "is seen where nothing is");
        if (sight.keyframe <= last) return of("track", t, "is seen twice in one keyframe");
        if (taken[sight.keyframe][sight.keypoint]++)
          return of("track", t, "has a sight that is another's");
        last = sight.keyframe;
      }
      if (track.is_landmark && !track.position.allFinite())
        return of("track", t, "is a landmark without a place");
    }
    return "";
  }

  std::string edges() const {
    for (std::size_t e = 0; e < contents_.filter_edges.size(); ++e) {
      const MapContents::OfEdge& edge = contents_.filter_edges[e];
      if (!in_use(edge.i) || !in_use(edge.j) || edge.i == edge.j ||
          !edge.measurement.direction.allFinite() ||
          !edge.measurement.i_from_j.coeffs().allFinite() ||
          !edge.measurement.sqrt_information.allFinite())
        return of("relative pose", e, "is none of two keyframes");
    }
    for (std::size_t e = 0; e < contents_.edges.size(); ++e)
      for (const Match& match : contents_.edges[e].matches)
        if (!has_keypoint(contents_.edges[e].i, match.a) ||
            !has_keypoint(contents_.edges[e].j, match.b))
          return of("edge", e, "has used what is not there");
    return "";
  }

  std::string measurements() const {
    const int n = static_cast<int>(contents_.keyframes.size());
    for (std::size_t a = 0; a < contents_.absolutes.size(); ++a) {
      const AbsoluteObservation& absolute = contents_.absolutes[a];
      if (!is_one_of(absolute.kind, AbsoluteObservation::Kind::kLandmarks))
        return of("absolute measurement", a, "is of no kind");
      for (const RigidPoint& point : absolute.points)
        if (!in_use(point.pose)) return of("absolute measurement", a, "is of no keyframe");
      if (absolute.kind == AbsoluteObservation::Kind::kLandmarks)
        for (int track : absolute.landmarks)
          if (!has_landmark(track)) return of("absolute measurement", a, "is of no landmark");
    }
    for (const auto* waiting : {&contents_.scale.waiting, &contents_.scale.contradicting})
      for (std::size_t m = 0; m < waiting->size(); ++m) {
        const PlacedMeasurement& placed = (*waiting)[m];
        if (!is_one_of(placed.kind, MeasurementKind::kLandmarks))
          return of("waiting measurement", m, "is of no kind");
        for (const PlacedPoint& point : placed.points)
          if (point.keyframe < 0 || point.keyframe >= n)
            return of("waiting measurement", m, "is of no keyframe");
        for (int track : placed.tracks)
          if (track < -1 || track >= contents_.num_tracks)
            return of("waiting measurement", m, "is of no track");
        const bool of_landmarks = placed.kind == MeasurementKind::kLandmarks;
        if (of_landmarks ? std::min(placed.tracks[0], placed.tracks[1]) < 0 : placed.points.empty())
          return of("waiting measurement", m, "is of nothing");
      }
    return "";
  }

  std::string rest() const {
    if (!is_one_of(contents_.map_sign, MapSign::kBoth) ||
        !is_one_of(contents_.scale.state.status, ScaleStatus::kFixed) ||
        !is_one_of(contents_.scale.earth.status, EarthStatus::kPlaced))
      return "its state is none";
    const NoiseBooks& noise = contents_.noise;
    if (!(noise.factor > 0) || !(noise.estimate > 0) || !std::isfinite(noise.factor) ||
        !std::isfinite(noise.estimate))
      return "its factor of sigmas is none";
    if (!contents_.places.words) return "";
    std::set<int> ids;
    for (const auto& [id, signature] : contents_.places.signatures)
      if (!in_use(id) || !ids.insert(id).second) return "its index of places is of another map";
    const auto used = static_cast<std::size_t>(
        std::count_if(contents_.keyframes.begin(), contents_.keyframes.end(),
                      [](const MapContents::OfKeyframe& k) { return k.carrier < 0; }));
    return ids.size() == used ? "" : "its index of places is not of all keyframes";
  }

  const MapContents& contents_;
};

}  // namespace

std::string problem_of(const MapContents& contents) {
  return Checker(contents).problem();
}

void Map::restore_keyframes(MapContents& contents) {
  const bool ready = contents.places.words != nullptr;
  for (MapContents::OfKeyframe& from : contents.keyframes) {
    const int k = num_keyframes();
    Keyframe keyframe;
    keyframe.time_us = from.time_us;
    if (from.carrier < 0) {
      if (!ready) places_.add(k, from.frame->frame);
      keyframe.track.assign(from.frame->size(), kNoTrack);
      keyframe.spent.assign(from.frame->size(), 0);
      keyframe.frame = std::move(from.frame);
    } else {
      keyframe.forget_seen();
      keyframe.carrier = from.carrier;
      keyframe.carrier_from_this = from.carrier_from_this;
      ++num_removed_;
    }
    keyframes_.push_back(std::move(keyframe));
    filter_.add_pose(from.pose);
  }
  for (int k = 0; k < num_keyframes(); ++k)
    if (is_removed(k)) filter_.remove_pose(k);
  if (ready) places_.restore(std::move(contents.places));
}

bool Map::restore_measurements(MapContents& contents) {
  for (MapContents::OfTrack& from : contents.tracks) {
    const int track = from.number;
    tracks_.extend(static_cast<std::size_t>(track));
    tracks_.push_back({});
    for (const Sight& sight : from.sights)
      keyframes_.write(sight.keyframe).track[sight.keypoint] = track;
    tracks_.write(track).sights = std::move(from.sights);
    if (from.is_landmark) promote(track, from.position, Eigen::Matrix3d::Zero());
  }
  tracks_.extend(static_cast<std::size_t>(contents.num_tracks));
  for (const MapContents::OfEdge& edge : contents.filter_edges)
    filter_.add_edge(edge.i, edge.j, edge.measurement);
  for (MapEdge& edge : contents.edges) spend(std::move(edge));
  for (AbsoluteObservation& absolute : contents.absolutes)
    if (absolute.kind == AbsoluteObservation::Kind::kLandmarks)
      for (int& landmark : absolute.landmarks) landmark = tracks_[landmark].landmark;
  return filter_.restore(contents.filter, contents.absolutes);
}

bool Map::restore(MapContents contents) {
  noise_.restore(contents.noise);
  restore_keyframes(contents);
  scale_ = std::move(contents.scale);
  num_bends_ = contents.num_bends;
  return restore_measurements(contents);
}

std::shared_ptr<Map> restore_map(MapContents contents, const Camera& camera,
                                 const MapperOptions& options) {
  if (!problem_of(contents).empty()) return nullptr;
  auto map = std::make_shared<Map>(camera, options);
  return map->restore(std::move(contents)) ? map : nullptr;
}

}  // namespace eifmap
