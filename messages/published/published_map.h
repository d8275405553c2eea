// A published map: the very values that went over the wire. The server keeps one of what it has
// sent, and each client one of what has arrived; where their digests agree, so do the maps.
#pragma once

#include <cstdint>
#include <eifmap/keyframe_t.hpp>
#include <eifmap/landmark_t.hpp>
#include <eifmap/map_part_t.hpp>
#include <eifmap/observation_t.hpp>
#include <map>
#include <string>
#include <vector>

namespace eifmap {

struct PublishedLandmark {
  landmark_t value;
  std::vector<observation_t> observations;  // of it, by keyframe ascending
};

// What updates did to a copy. Ids, in no order, some of them twice.
struct MapChange {
  // The copy begins anew: another map, the map in another unit, or what was missed is too much.
  bool whole = false;
  std::vector<std::int64_t> keyframes, landmarks;  // new, changed or seen from another keyframe
  std::vector<std::int64_t> removed_landmarks;
};

class PublishedMap {
 public:
  // Takes an update over, which is to follow on from seq() or to be a whole map. Observations of
  // landmarks that are not in the map are passed over.
  void apply(const map_part_t& update);
  // As one update: base_seq -1, entries by their ids ascending.
  map_part_t whole() const;
  std::size_t whole_bytes() const;  // of its entries, encoded

  const std::string& camera() const { return camera_; }
  std::int64_t server_epoch() const { return server_epoch_; }
  std::int64_t map_id() const { return map_id_; }
  std::int64_t map_epoch() const { return map_epoch_; }
  std::int64_t seq() const { return seq_; }  // 0: nothing yet
  std::int64_t digest() const { return static_cast<std::int64_t>(digest_); }

  const std::map<std::int64_t, keyframe_t>& keyframes() const { return keyframes_; }  // by id
  const std::map<std::int64_t, PublishedLandmark>& landmarks() const {
    return landmarks_;
  }  // by id
  std::int64_t num_observations() const { return num_observations_; }

 private:
  void clear();
  void take(const keyframe_t& keyframe);
  void take(const landmark_t& landmark);
  void take(const observation_t& observation);
  void remove(std::int64_t landmark);

  std::string camera_;
  std::int64_t utime_ = 0, server_epoch_ = 0, map_id_ = 0, map_epoch_ = 0, seq_ = 0;
  std::map<std::int64_t, keyframe_t> keyframes_;
  std::map<std::int64_t, PublishedLandmark> landmarks_;
  std::int64_t num_observations_ = 0;
  std::uint64_t digest_ = 0;
};

// Where a landmark is in the map, x y z; false, and nothing said, while its anchor is not there.
bool position_in_map(const PublishedMap& map, const landmark_t& landmark, double position[3]);

}  // namespace eifmap
