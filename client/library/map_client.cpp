#include "eifmap/map_client.h"

#include <chrono>
#include <lcm/lcm-cpp.hpp>
#include <stdexcept>

#include "published/map_follower.h"
#include "published/said_of_map.h"
#include "wire/channel.h"
#include "wire/clock.h"
#include "wire/limits.h"

namespace eifmap {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kSilence = std::chrono::seconds(3);
// Parts that may wait in LCM while the program does something else.
constexpr int kQueue = 2000;

// liblcm passes on whatever sizes a datagram claims, and is C: nothing may be thrown through it.
void dispatch(const lcm::ReceiveBuffer* buffer, const std::string& channel,
              MapClient* client) noexcept {
  if (buffer->data_size > kMaxMessageBytes) return;
  try {
    client->receive(channel, buffer->data, buffer->data_size);
  } catch (...) {
    // Only memory can run out here: the message is lost, as others are on a network.
  }
}

}  // namespace

struct MapClient::State {
  State(const std::string& name, Send to_send)
      : camera(name), send(std::move(to_send)), follower(random_requester()) {
    if (!name.empty()) require_camera_name(name);
  }

  void take_part(Bytes bytes);
  void take_said(const Decoded<SaidOfMap>& said);
  bool is_ours(const std::string& of);

  std::string camera;
  Send send;
  MapFollower follower;
  OnChange on_change;
  Counts counts;
  Clock::time_point heard{};
  lcm::LCM* lcm = nullptr;
  std::vector<lcm::Subscription*> subscriptions;
};

// A camera is chosen by what a server says of its map, by nobody else.
bool MapClient::State::is_ours(const std::string& of) {
  if (camera.empty()) camera = of;
  if (of != camera) return false;
  heard = Clock::now();
  return true;
}

void MapClient::State::take_part(Bytes bytes) {
  const Decoded<map_part_t> part = decode_map_part(bytes);
  counts.malformed += part.ok() ? 0 : 1;
  if (!part.ok() || !is_ours(part.value.camera)) return;
  ++counts.parts;
  if (follower.take(part.value, Clock::now()) != MapFollower::Outcome::kApplied) return;
  const MapChange change = follower.take_changes();
  if (on_change) on_change(change);
}

void MapClient::State::take_said(const Decoded<SaidOfMap>& said) {
  counts.malformed += said.ok() ? 0 : 1;
  if (!said.ok() || !valid_camera_name(said.value.camera) || !is_ours(said.value.camera)) return;
  const SaidOfMap& s = said.value;
  follower.hear(s.camera, s.server_epoch, s.map_seq, Clock::now(), s.map_digest);
}

MapClient::MapClient(const std::string& camera, Send send)
    : state_(std::make_unique<State>(camera, std::move(send))) {}

MapClient::MapClient(lcm::LCM& lcm, const std::string& camera)
    : MapClient(camera, [&lcm](const std::string& channel, const std::vector<std::uint8_t>& bytes) {
        lcm.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
      }) {
  state_->lcm = &lcm;
  for (const ChannelKind kind : {ChannelKind::kMap, ChannelKind::kPose, ChannelKind::kStatus}) {
    lcm::Subscription* const subscription =
        lcm.subscribeFunction(channel_pattern(camera, kind), &dispatch, this);
    subscription->setQueueCapacity(kQueue);
    state_->subscriptions.push_back(subscription);
  }
}

MapClient::~MapClient() {
  if (!state_->lcm) return;
  for (lcm::Subscription* const subscription : state_->subscriptions)
    state_->lcm->unsubscribe(subscription);
}

void MapClient::on_change(OnChange on_change) {
  state_->on_change = std::move(on_change);
}

void MapClient::receive(const std::string& channel, const void* data, std::size_t size) {
  const std::optional<Channel> parsed = parse_channel(channel);
  if (!parsed || (!state_->camera.empty() && parsed->camera != state_->camera)) return;
  const Bytes bytes(static_cast<const std::uint8_t*>(data), size);
  if (parsed->kind == ChannelKind::kMap)
    state_->take_part(bytes);
  else if (parsed->kind == ChannelKind::kPose)
    state_->take_said(said_by_pose(bytes));
  else if (parsed->kind == ChannelKind::kStatus && parsed->camera != kNoCamera)
    state_->take_said(said_by_status(bytes));
}

void MapClient::tick() {
  const auto request = state_->follower.ask(Clock::now(), now_us());
  if (!request) return;
  state_->send(channel_name(request->camera, ChannelKind::kMapRequest), encode(*request));
}

const std::string& MapClient::camera() const {
  return state_->camera;
}

const PublishedMap& MapClient::map() const {
  return state_->follower.map();
}

bool MapClient::is_stale() const {
  return state_->follower.map().seq() == 0 || state_->follower.is_stale();
}

bool MapClient::hears_server() const {
  return state_->heard != Clock::time_point{} && Clock::now() - state_->heard < kSilence;
}

MapClient::Counts MapClient::counts() const {
  Counts counts = state_->counts;
  const MapFollower::Counts& follower = state_->follower.counts();
  counts.updates = follower.updates;
  counts.whole_maps = follower.whole_maps;
  counts.requests = follower.requests;
  counts.wrong_digests = follower.wrong_digests;
  return counts;
}

}  // namespace eifmap
