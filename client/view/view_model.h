// What every page shows, as JSON: the whole of it for a page that comes late, and what is new since
// the last time for those that are there. A page that took the snapshot and one that took every
// increment hold the same.
//
// Both are one object of sections; what a section says replaces what it said before, but for:
//   snapshot    true: what was before is void          clear  true: path and map are void
//   path        {from, steps: [x, y, z, joined] * n}   steps from `from` on are these
//   keyframes   [id, x, y, z, qw, qx, qy, qz] * n      new or moved, map_from_camera
//   landmarks   [id, anchor, x, y, z, observations * sign, sigma or -1] * n  in the anchor's frame
//   removed_keyframes, removed_landmarks               ids
// Lengths are in map units (metres where "scale" says "metric"), rounded to 1e-5.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "client/view/shown_map.h"
#include "client/view/shown_path.h"
#include "convert/camera_message.h"
#include "convert/feature_message.h"
#include "convert/pose_message.h"
#include "convert/status_message.h"
#include "published/map_follower.h"

namespace eifmap {

class ViewModel {
 public:
  using Clock = std::chrono::steady_clock;
  using Json = nlohmann::ordered_json;

  // `requester`: of map requests, random per start and not 0.
  explicit ViewModel(Clock::time_point start = Clock::now(), std::int64_t requester = 1)
      : follower_(requester), last_heard_(start) {}

  // `now`: when it came. What an older run of the server or an older map says is passed over.
  void take(const PublishedPose& pose, Clock::time_point now);
  void take(const map_part_t& part, Clock::time_point now);
  void take(const status_t& status, Clock::time_point now);
  void take(const NamedCamera& camera);
  void take(const FeatureFrame& features);
  void forget_features();
  void set_camera(const std::string& camera);
  void note_malformed() { ++malformed_; }

  // The run of the server that is shown; nothing before the first.
  std::optional<std::int64_t> server_epoch() const { return server_epoch_; }
  // It said that it stops, or was not heard for kSilence.
  bool server_is_gone(Clock::time_point now) const;

  // What is to be sent to the server, since parts of the map are missing. `utime`: us since the
  // Unix epoch.
  std::optional<map_request_t> ask(Clock::time_point now, std::int64_t utime) {
    return follower_.ask(now, utime);
  }

  // What changed since the last call, "" for nothing.
  std::string take_increment(Clock::time_point now);
  // As of the last increment.
  std::string snapshot() const;

  static constexpr auto kSilence = std::chrono::seconds(3);  // a server that lives is not silent
  // Parts of a map are on their way for a moment, always; this long, and it is said.
  static constexpr auto kBehind = std::chrono::seconds(1);

 private:
  bool take_epoch(std::int64_t server_epoch, Clock::time_point now);
  bool take_map(std::int64_t map_id, std::int64_t map_epoch);
  void take_scale(const ScaleState& scale);
  void begin_map(std::int64_t map_id);
  void tell(const std::string& event);
  void set(const char* section, Json value);
  void describe_state(Clock::time_point now);
  void describe_pose();
  void describe_silence(Clock::time_point now);
  void describe_map(Clock::time_point now);
  void add_map_changes(Json& increment);
  void add_path(Json& increment);

  std::optional<std::int64_t> server_epoch_;
  std::int64_t map_id_ = 0;             // of path and map; 0 none yet
  std::int64_t map_epoch_ = 0;          // the greatest of them; maps are ordered by it
  std::int64_t largest_map_id_ = 0;     // so far; a map with a lower one was in use before
  ScaleState scale_;                    // of that map
  std::optional<FrameResult> pose_;     // the last one
  std::optional<FrameResult> tracked_;  // the last with a pose in this map
  std::optional<status_t> status_;      // the last one
  bool status_is_newer_ = false;        // than the pose
  MapFollower follower_;
  std::optional<Clock::time_point> behind_since_;
  bool map_moved_ = false, cleared_ = false;
  ShownMap map_;
  ShownPath path_;
  std::deque<std::pair<std::int64_t, std::string>> events_;  // the last ones, numbered
  std::int64_t num_events_ = 0, malformed_ = 0;
  Clock::time_point last_heard_;
  std::map<std::string, Json> sections_;  // as the pages have them
  std::map<std::string, Json> changed_;   // since the last increment
};

}  // namespace eifmap
