// Where every frame was, relative to a keyframe: so that it follows when the keyframe is corrected.
#pragma once

#include <algorithm>
#include <vector>

#include "map/map.h"
#include "map_view.h"
#include "shared_vector.h"

namespace eifmap {

class TrajectoryLog {
 public:
  struct Entry {
    std::int64_t time_us = 0;
    int keyframe = 0;
    Rigid3 keyframe_from_camera;
  };
  using Entries = SharedVector<Entry, 64>;  // copies share what is long past

  void add(std::int64_t time_us, int keyframe, const Rigid3& keyframe_from_camera) {
    entries_.push_back({time_us, keyframe, keyframe_from_camera});
  }
  // The frame of that time, which has been added, is a keyframe now.
  void make_keyframe(std::int64_t time_us, int keyframe) {
    for (std::size_t e = entries_.size(); e-- > 0;)
      if (entries_[e].time_us == time_us) {
        entries_.write(e) = {time_us, keyframe, Rigid3()};
        return;
      }
  }
  void make_metric(double metres_per_unit) {
    for (std::size_t e = 0; e < entries_.size(); ++e)
      entries_.write(e).keyframe_from_camera.translation *= metres_per_unit;
  }
  // By keyframe, how much what is near it has grown: Map::bend().
  void grow(const std::vector<double>& growth) {
    for (std::size_t e = 0; e < entries_.size(); ++e) {
      Entry& entry = entries_.write(e);
      entry.keyframe_from_camera.translation *= growth[static_cast<std::size_t>(entry.keyframe)];
    }
  }
  // That of another map, which is in this one now; its frames came before this one's newest.
  // Or, as the `newest`, after all of them.
  void include(const TrajectoryLog& other, const Appended& appended, bool newest) {
    Entries others;
    for (Entry e : other.entries_) {
      e.keyframe += appended.first_keyframe;
      e.keyframe_from_camera.translation *= appended.growth;
      others.push_back(e);
    }
    if (!newest) std::swap(entries_, others);
    for (const Entry& e : others) entries_.push_back(e);
  }
  bool newest_is(std::int64_t time_us) const {
    return !entries_.empty() && entries_.back().time_us == time_us;
  }
  std::size_t size() const { return entries_.size(); }
  const Entries& entries() const { return entries_; }

  // By time.
  std::vector<TimedPose> in(const Map& map) const {
    std::vector<TimedPose> poses;
    poses.reserve(entries_.size());
    for (const Entry& e : entries_)
      poses.push_back({e.time_us, map.pose(e.keyframe) * e.keyframe_from_camera});
    std::stable_sort(poses.begin(), poses.end(),
                     [](const TimedPose& a, const TimedPose& b) { return a.time_us < b.time_us; });
    return poses;
  }

 private:
  Entries entries_;
};

}  // namespace eifmap
