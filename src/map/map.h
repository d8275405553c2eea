// The map: keyframes, tracks of Omega_m features through them, and the filter that holds the
// estimates. A track with a place in the filter is a landmark; without one it is a candidate.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "filter/information_filter.h"
#include "geometry/rigid3.h"
#include "geometry/similarity.h"
#include "map/map_scale.h"
#include "map/observed_frame.h"
#include "map/sight_noise.h"
#include "map_view.h"
#include "options.h"
#include "place/place_index.h"
#include "shared_vector.h"

namespace eifmap {

inline constexpr int kNoTrack = -1;

// Keyframes are numbered from 0; keyframe k is pose k of the filter.
struct Keyframe {
  std::int64_t time_us = 0;                    // of its image
  std::shared_ptr<const ObservedFrame> frame;  // what was seen never changes: copies share it
  std::vector<int> track;                      // per keypoint: of Omega_m, or kNoTrack
  std::vector<std::uint8_t> spent;  // per keypoint: of Omega_p, 1 when an edge has used it
  const ObservedFrame& observed() const { return *frame; }

  // Takes out what was seen; it is nothing from then on.
  void forget_seen();
  // Once it is removed: what it is relative to, one that is in the map.
  int carrier = -1;
  Rigid3 carrier_from_this;
  bool removed() const { return carrier >= 0; }
};

struct Sight {
  int keyframe = 0, keypoint = 0;
};

struct Track {
  std::vector<Sight> sights;  // by keyframe ascending, one per keyframe; empty: removed
  int landmark = -1;          // in the filter; -1: a candidate
  bool is_landmark() const { return landmark >= 0; }
};

// A relative-pose edge that was made, with the measurements it has used; a: in i, b: in j. The
// filter may have dropped it since.
struct MapEdge {
  int i = 0, j = 0;
  std::vector<Match> matches;
};
using MapEdges = SharedVector<MapEdge, 8>;

struct MapContents;  // map_contents.h

// Where what another map had is now, and how much it has grown.
struct Appended {
  int first_keyframe = 0, first_track = 0;
  double growth = 1;
};

class Map {
 public:
  Map(const Camera& camera, const MapperOptions& options);

  int num_keyframes() const { return static_cast<int>(keyframes_.size()); }  // removed ones too
  int num_tracks() const { return static_cast<int>(tracks_.size()); }
  int num_landmarks() const { return num_landmarks_; }
  const Keyframe& keyframe(int k) const { return keyframes_[k]; }
  const Track& track(int t) const { return tracks_[t]; }
  const Rigid3& pose(int k) const { return filter_.pose(k); }
  const Eigen::Vector3d& position(int track) const {
    return filter_.position(tracks_[track].landmark);
  }
  const Eigen::Matrix3d& position_covariance(int track) const {  // given the poses
    return filter_.landmark(tracks_[track].landmark).covariance;
  }
  const InformationFilter& filter() const { return filter_; }
  InformationFilter& filter() { return filter_; }

  // Returns the keyframe's number.
  int add_keyframe(std::shared_ptr<const ObservedFrame> observed, const Rigid3& world_from_camera);
  int add_keyframe(ObservedFrame observed, const Rigid3& world_from_camera) {
    return add_keyframe(std::make_shared<const ObservedFrame>(std::move(observed)),
                        world_from_camera);
  }

  // Puts the map where it belongs as a whole, as after a loop is closed: each keyframe (removed
  // ones are passed over) to its world_from_keyframe, whose scale is how much what is near it
  // grows, and landmarks with the keyframe in the middle of their tracks. A start for the next
  // update, and no information: see InformationFilter::move() also for what is refused. The first
  // keyframe stays. Returns by keyframe how much what is near it has grown; of a removed one, its
  // carrier's.
  std::vector<double> bend(const std::vector<Similarity>& world_from_keyframe);

  // Puts what another map holds after what this one does, where world_from_other says: keyframes
  // (removed ones, too), tracks, sights and edges, each with the number that it had more by what
  // is said. Nothing is lost by it, and nothing known that was not: the other's gauge was by
  // definition and is dropped, and how the two maps are to each other only what they share will
  // tell, which is to be joined before the next update. Throws std::invalid_argument, and changes
  // nothing, where the scale is not positive, the other map's features are of another Laplacian
  // sign, or it has absolute measurements (is_measured()).
  Appended append(const Map& other, const Similarity& world_from_other);

  // Takes a keyframe out of the map: its sights, the landmarks that less than two are left of, its
  // edges, whose measurements may be used again by the other keyframe, and what was seen in it.
  // Information is lost by it, and none invented. Its number stays valid: pose() is from then on
  // that relative to the keyframe that shared the most with it, so that frames which are placed
  // relative to it can still be placed. The filter takes notice in the next update(). Not of the
  // first two, which are the gauge, nor of a removed one: std::invalid_argument. What is left must
  // hold together: the caller's to see to (map_bounds.h).
  void remove_keyframe(int keyframe);
  int newest() const;  // keyframe in use
  bool is_removed(int keyframe) const { return keyframes_[keyframe].removed(); }
  int num_keyframes_in_use() const { return num_keyframes() - num_removed_; }

  // All that is in units of the map becomes metres.
  void make_metric(double metres_per_unit);

  // A new candidate with one sighting.
  int add_track(const Sight& sight);
  // Adds a sighting; of a landmark, the measurement enters the filter. Refused (false) when the
  // track has a sighting in that keyframe or the keypoint has a track.
  bool add_sight(int track, const Sight& sight);
  void remove_sight(int track, int keyframe);
  void remove_track(int track);
  // What turns out to be one feature: `gone` gives its sights to `kept`, and is no more. Refused
  // (false) when they are seen in the same keyframe, or are the same, or `gone` is in a measured
  // distance.
  bool join_tracks(int kept, int gone);
  // Puts a candidate with all its sightings into the filter.
  void promote(int track, const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance);

  // An edge has used these matches: none of them is to be used again.
  void spend(MapEdge edge);
  const MapEdges& edges() const { return edges_; }

  // Of the keyframes in use, by their numbers.
  const PlaceIndex& places() const { return places_; }

  // Its scale, and what is to fix it.
  const MapScale& scale() const { return scale_; }
  MapScale& scale() { return scale_; }
  // 1 more when all of it has changed at once, as when it became metric or a loop was closed.
  int epoch() const { return num_bends_ + (is_metric() ? 1 : 0); }
  bool is_metric() const { return scale_.state.status == ScaleStatus::kFixed; }
  bool is_measured() const;  // has absolute measurements, or some that wait
  MapSign map_sign() const { return keyframe(0).observed().map_sign; }  // of one that has begun
  int num_bends() const { return num_bends_; }

  // Landmarks (tracks) that a measured distance is of, ascending: not to be given up for less than
  // a want of sights, since the scale may rest on them.
  std::vector<int> measured_tracks() const;

  // Updates the filter and lets the map follow what it dropped.
  FilterUpdate update();

  // How many landmarks each keyframe shares with this one; of itself 0.
  std::vector<int> num_shared(int keyframe) const;
  // Keyframes that share the most landmarks with `keyframe` (itself first), at most `count`.
  std::vector<int> covisible(int keyframe, int count) const;
  // Landmarks (tracks) seen from any of the keyframes, ascending.
  std::vector<int> landmarks_of(const std::vector<int>& keyframes) const;
  // Depths of the landmarks seen from the keyframe, in no order; their median, 0 of none.
  std::vector<double> depths(int keyframe) const;
  double median_depth(int keyframe) const;

  // For a map that is kept in a file (map_contents.h): its tables as they are, the newest of which
  // a copy from before shares most pieces with, and its track of a landmark of the filter.
  const SharedVector<Track, 64>& tracks() const { return tracks_; }
  int track_of_landmark(int landmark) const { return track_of_landmark_[landmark]; }
  const SightNoise& noise() const { return noise_; }

  double radians_per_pixel() const { return radians_per_pixel_; }
  // What sigmas of keypoints are multiplied by: those of all sights so far, and of frames to come.
  double sigma_factor() const { return noise_.factor(); }

 private:
  friend std::shared_ptr<Map> restore_map(MapContents contents, const Camera& camera,
                                          const MapperOptions& options);
  bool restore(MapContents contents);
  void restore_keyframes(MapContents& contents);
  bool restore_measurements(MapContents& contents);
  void add_measurement(int landmark, const Sight& sight);
  void carry_removed();
  void append_keyframes(const Map& other, const Similarity& world_from_other);
  void append_tracks(const Map& other, const Similarity& world_from_other, int first_keyframe);
  void append_edges(const Map& other, int first_keyframe);

  double radians_per_pixel_;
  // Copies share what a keyframe does not reach.
  SharedVector<Keyframe, 1> keyframes_;
  SharedVector<Track, 64> tracks_;
  MapEdges edges_;
  PlaceIndex places_;
  InformationFilter filter_;
  SightNoise noise_;
  MapScale scale_;
  SharedVector<int, 1024> track_of_landmark_;
  int num_landmarks_ = 0;
  int num_removed_ = 0;  // keyframes
  int num_bends_ = 0;
};

}  // namespace eifmap
