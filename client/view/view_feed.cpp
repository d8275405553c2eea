#include "client/view/view_feed.h"

#include "wire/clock.h"

namespace eifmap {
namespace {

// What may wait in LCM while a large snapshot is written: nothing is lost of poses, map and the
// parts of feature frames; of images the next ones will do.
constexpr int kQueue = 2000, kImageQueue = 2;

bool is_servers(ChannelKind kind) {
  return kind == ChannelKind::kPose || kind == ChannelKind::kMap || kind == ChannelKind::kStatus;
}

}  // namespace

ViewFeed::ViewFeed(const std::string& camera, View& view, Bus& bus)
    : camera_(camera), view_(view), bus_(bus) {
  if (!camera.empty()) view_.model.set_camera(camera);
  subscribe(camera, ChannelKind::kPose, &ViewFeed::receive_pose);
  subscribe(camera, ChannelKind::kMap, &ViewFeed::receive_map);
  subscribe(camera, ChannelKind::kStatus, &ViewFeed::receive_status);
  subscribe(camera, ChannelKind::kCalibration, &ViewFeed::receive_calibration);
  subscribe(camera, ChannelKind::kFeatures, &ViewFeed::receive_features);
  subscribe(camera, ChannelKind::kImage, &ViewFeed::receive_image);
  if (!camera.empty() && camera != kNoCamera)
    subscribe(kNoCamera, ChannelKind::kStatus, &ViewFeed::receive_status);
}

ViewFeed::~ViewFeed() {
  bus_.unsubscribe_all();
}

// Of other cameras only the status is looked into: it may be of a server that has no camera yet.
// Which camera it is, the server says; what publishers send before that is passed over.
void ViewFeed::subscribe(std::string_view camera, ChannelKind kind,
                         void (ViewFeed::*handler)(Bytes)) {
  bus_.subscribe(channel_pattern(camera, kind), kind == ChannelKind::kImage ? kImageQueue : kQueue,
                 [this, kind, handler](const std::string& channel, Bytes bytes) {
                   const auto parsed = parse_channel(channel);
                   if (!parsed) return;
                   const bool open = camera_.empty() && is_servers(kind);
                   if (open || kind == ChannelKind::kStatus || parsed->camera == camera_)
                     (this->*handler)(bytes);
                 });
}

void ViewFeed::tick() {
  if (const auto request = view_.model.ask(Clock::now(), now_us()))
    bus_.publish(channel_name(request->camera, ChannelKind::kMapRequest), encode(*request));
}

void ViewFeed::choose(const std::string& camera) {
  server_has_camera_ = true;
  if (!camera_.empty()) return;
  camera_ = camera;
  view_.model.set_camera(camera);
}

void ViewFeed::receive_pose(Bytes bytes) {
  const auto pose = decode_pose(bytes);
  if (!pose.ok()) return view_.model.note_malformed();
  choose(pose.value.origin.camera);
  view_.model.take(pose.value, Clock::now());
}

void ViewFeed::receive_map(Bytes bytes) {
  const auto part = decode_map_part(bytes);
  if (!part.ok()) return view_.model.note_malformed();
  choose(part.value.camera);
  view_.model.take(part.value, Clock::now());
}

void ViewFeed::receive_status(Bytes bytes) {
  const auto status = decode_status(bytes);
  if (!status.ok()) return view_.model.note_malformed();
  const Clock::time_point now = Clock::now();
  const std::string& camera = status.value.camera;
  if (camera.empty()) {
    // A server without a camera is this one's only as long as there is no other; and where the same
    // has this camera, it speaks of further ones.
    const bool same = view_.model.server_epoch() == status.value.server_epoch;
    if (server_has_camera_ && (same || !view_.model.server_is_gone(now))) return;
  } else {
    if (!camera_.empty() && camera != camera_) return;
    choose(camera);
  }
  view_.model.take(status.value, now);
}

void ViewFeed::receive_calibration(Bytes bytes) {
  const auto camera = decode_camera(bytes);
  if (!camera.ok()) return view_.model.note_malformed();
  view_.model.take(camera.value);
}

void ViewFeed::receive_features(Bytes bytes) {
  auto part = decode_feature_part(bytes);
  if (!part.ok()) return view_.model.note_malformed();
  for (const FeatureFrame& frame : parts_.add(std::move(part.value))) {
    const Clock::time_point now = Clock::now();
    if (now < features_shown_ + kPicturePeriod) continue;
    features_shown_ = now;
    if (now > image_shown_ + kPictureSilence) view_.picture.clear();
    view_.model.take(frame);
  }
}

void ViewFeed::receive_image(Bytes bytes) {
  const Clock::time_point now = Clock::now();
  if (now < image_shown_ + kPicturePeriod) return;
  image_shown_ = now;
  const auto image = decode_image(bytes);
  if (!image.ok()) return view_.model.note_malformed();
  if (now > features_shown_ + kPictureSilence) view_.model.forget_features();
  view_.picture.take(image.value);
}

}  // namespace eifmap
