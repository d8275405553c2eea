#include "client/view/view_model.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "client/view/view_json.h"
#include "names.h"

namespace eifmap {
namespace {

constexpr std::size_t kEventsKept = 5;
constexpr const char *kStopped = "STOPPED", *kPaused = "PAUSED";

// What the last word of the server amounts to.
struct Headline {
  std::string state = "NO SERVER";
  Reason reason = Reason::kNone;
  std::string text, hint;
};

std::string agreement(const FrameResult& pose) {
  return std::to_string(pose.num_inliers) + " of " + std::to_string(pose.num_matches) +
         " map features agree with the pose";
}

Headline headline_of(const status_t& status) {
  Headline headline;
  headline.state = status.state == status_t::STATE_STOPPING ? kStopped
                   : status.state == status_t::STATE_PAUSED
                       ? kPaused
                       : std::string(name(static_cast<TrackingState>(status.state)));
  headline.reason = static_cast<Reason>(status.reason);
  headline.text = status.message;
  headline.hint = status.hint;
  return headline;
}

Headline headline_of(const FrameResult& pose) {
  Headline headline;
  headline.state = name(pose.state);
  headline.reason = pose.reason;
  if (pose.reason != Reason::kNone) {
    headline.text = describe(pose.reason).text;
    headline.hint = describe(pose.reason).hint;
  } else if (pose.state == TrackingState::kTracking) {
    headline.text = agreement(pose);
  }
  return headline;
}

}  // namespace

void ViewModel::take(const PublishedPose& message, Clock::time_point now) {
  const FrameResult& pose = message.result;
  if (!take_epoch(message.origin.server_epoch, now)) return;
  if (pose.map_id != 0 && !take_map(pose.map_id, pose.map_epoch)) return;
  follower_.hear(message.origin.camera, message.origin.server_epoch, pose.map_seq, now);
  take_scale(pose.scale);
  pose_ = pose;
  status_is_newer_ = false;
  if (pose.state == TrackingState::kTracking) {
    tracked_ = pose;
    const bool is_late = pose.scale.status != scale_.status;  // said before the map became metric
    path_.add((is_late ? scale_.metres_per_unit : 1) * pose.map_from_camera.translation);
  } else {
    path_.interrupt();
  }
}

void ViewModel::take(const map_part_t& part, Clock::time_point now) {
  if (!take_epoch(part.server_epoch, now) || !take_map(part.map_id, part.map_epoch)) return;
  if (follower_.take(part, now) == MapFollower::Outcome::kApplied) map_moved_ = true;
}

void ViewModel::take(const status_t& status, Clock::time_point now) {
  if (!take_epoch(status.server_epoch, now)) return;
  if (status.state == status_t::STATE_STOPPING &&
      !(status_ && status_->state == status_t::STATE_STOPPING))
    tell("the server stopped");
  status_ = status;
  status_is_newer_ = true;
  if (!status.camera.empty())
    follower_.hear(status.camera, status.server_epoch, status.map_seq, now, status.map_digest);
}

void ViewModel::take(const NamedCamera& camera) {
  set("lens", view_json::lens(camera));
}

void ViewModel::take(const FeatureFrame& features) {
  set("features", view_json::features(features));
}

void ViewModel::forget_features() {
  if (sections_.contains("features")) set("features", nullptr);
}

void ViewModel::set_camera(const std::string& camera) {
  set("camera", camera);
}

bool ViewModel::server_is_gone(Clock::time_point now) const {
  return now - last_heard_ >= kSilence || (status_ && status_->state == status_t::STATE_STOPPING);
}

// Each run of a server has an epoch of its own, and later runs have greater ones.
bool ViewModel::take_epoch(std::int64_t server_epoch, Clock::time_point now) {
  if (server_epoch_ && server_epoch < *server_epoch_) return false;
  last_heard_ = now;
  if (server_epoch_ == server_epoch) return true;
  if (server_epoch_) {
    tell("server restarted: a new map");
    begin_map(0);
    map_epoch_ = largest_map_id_ = 0;
    pose_.reset();
    status_.reset();
    set("features", nullptr);
  }
  server_epoch_ = server_epoch;
  return true;
}

bool ViewModel::take_map(std::int64_t map_id, std::int64_t map_epoch) {
  if (map_id != map_id_) {
    if (std::tie(map_epoch, map_id) < std::tie(map_epoch_, map_id_)) return false;
    if (map_id > largest_map_id_ && map_id_ != 0)
      tell("a new map was begun: map " + std::to_string(map_id));
    else if (map_id_ != 0)
      tell("the camera is in map " + std::to_string(map_id) + " again");
    begin_map(map_id);
  }
  map_epoch_ = std::max(map_epoch_, map_epoch);
  largest_map_id_ = std::max(largest_map_id_, map_id);
  return true;
}

// The path is of published poses: those before the map became metric are in its old unit.
void ViewModel::take_scale(const ScaleState& scale) {
  if (scale.status == ScaleStatus::kFree) return;
  if (scale_.status == ScaleStatus::kFree && !path_.steps().empty()) {
    path_.scale_by(scale.metres_per_unit);
    tell("the map is in metres now");
  }
  scale_ = scale;
}

void ViewModel::begin_map(std::int64_t map_id) {
  map_id_ = map_id;
  scale_ = {};
  tracked_.reset();
  path_.clear();
  map_.clear();
  map_moved_ = false;
  cleared_ = true;
}

void ViewModel::tell(const std::string& event) {
  events_.emplace_back(++num_events_, event);
  if (events_.size() > kEventsKept) events_.pop_front();
  Json list = Json::array();
  for (const auto& [number, text] : events_) list.push_back({{"number", number}, {"text", text}});
  set("events", std::move(list));
}

void ViewModel::set(const char* section, Json value) {
  const auto [known, is_new] = sections_.try_emplace(section);
  if (!is_new && known->second == value) return;
  known->second = value;
  changed_[section] = std::move(value);
}

void ViewModel::describe_state(Clock::time_point now) {
  Headline headline;
  if (pose_ && !status_is_newer_)
    headline = headline_of(*pose_);
  else if (status_)
    headline = headline_of(*status_);
  // The pose has the code alone; the status of the same has the numbers too.
  if (const Headline said = status_ ? headline_of(*status_) : Headline();
      said.reason == headline.reason && said.state == headline.state &&
      headline.reason != Reason::kNone)
    headline = said;
  if (now - last_heard_ >= kSilence && headline.state != kStopped) {
    headline = {};
    if (server_epoch_) headline.text = "what is shown is what it said last";
  }
  set("state", {{"state", headline.state},
                {"reason", headline.reason == Reason::kNone ? "" : describe(headline.reason).name},
                {"text", headline.text},
                {"hint", headline.hint}});
}

void ViewModel::describe_pose() {
  Json json;
  if (tracked_) {
    json = view_json::pose(*tracked_);
    json["current"] = pose_ && pose_->state == TrackingState::kTracking;
    json["source"] = name(tracked_->source);
    json["optimistic"] = tracked_->covariance_status == CovarianceStatus::kOptimistic;
  }
  set("pose", std::move(json));
}

void ViewModel::describe_silence(Clock::time_point now) {
  const auto silence = now - last_heard_;
  set("silence_s",
      silence < kSilence ? 0 : std::chrono::duration_cast<std::chrono::seconds>(silence).count());
}

void ViewModel::add_path(Json& increment) {
  if (path_.changed()) increment["path"] = view_json::path(path_, path_.first_unsent());
  path_.mark_sent();
}

void ViewModel::describe_map(Clock::time_point now) {
  if (!follower_.is_stale())
    behind_since_.reset();
  else if (!behind_since_)
    behind_since_ = now;
  set("map", {{"id", map_id_},
              {"behind", behind_since_ && now - *behind_since_ >= kBehind},
              {"scale", name(scale_.status)},
              {"scale_sigma", std::isfinite(scale_.sigma) ? Json(scale_.sigma) : Json(nullptr)}});
}

void ViewModel::add_map_changes(Json& increment) {
  const PublishedMap& map = follower_.map();
  const bool is_shown = map.map_id() == map_id_ && map.server_epoch() == server_epoch_;
  if (!is_shown || !std::exchange(map_moved_, false)) return;
  const MapChanges changes = map_.update(map);
  const auto add_entries = [&increment](const char* section, const auto& entries) {
    if (entries.empty()) return;
    Json list = Json::array();
    for (const auto& [id, entry] : entries) view_json::append(list, id, entry);
    increment[section] = std::move(list);
  };
  add_entries("keyframes", changes.keyframes);
  add_entries("landmarks", changes.landmarks);
  if (!changes.removed_keyframes.empty())
    increment["removed_keyframes"] = changes.removed_keyframes;
  if (!changes.removed_landmarks.empty())
    increment["removed_landmarks"] = changes.removed_landmarks;
}

std::string ViewModel::take_increment(Clock::time_point now) {
  describe_state(now);
  describe_pose();
  describe_silence(now);
  if (status_) set("server", view_json::status(*status_));
  describe_map(now);
  set("malformed", malformed_);

  Json increment = Json::object();
  if (std::exchange(cleared_, false)) increment["clear"] = true;
  for (auto& [section, value] : std::exchange(changed_, {})) increment[section] = std::move(value);
  add_path(increment);
  add_map_changes(increment);
  return increment.empty() ? "" : view_json::text_of(increment);
}

std::string ViewModel::snapshot() const {
  Json json{{"snapshot", true}};
  for (const auto& [section, value] : sections_) json[section] = value;
  json["path"] = view_json::path(path_, 0);
  Json keyframes = Json::array(), landmarks = Json::array();
  for (const auto& [id, keyframe] : map_.keyframes()) view_json::append(keyframes, id, keyframe);
  for (const auto& [id, landmark] : map_.landmarks()) view_json::append(landmarks, id, landmark);
  json["keyframes"] = std::move(keyframes);
  json["landmarks"] = std::move(landmarks);
  return view_json::text_of(json);
}

}  // namespace eifmap
