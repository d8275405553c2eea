#include "server/mapping_server.h"

#include <algorithm>
#include <utility>

#include "convert/decision_message.h"
#include "convert/map_message.h"
#include "wire/clock.h"

namespace eifmap {
namespace {

using std::chrono::milliseconds;

// liblcm's own queue, per subscription. When it is full, liblcm drops what comes.
constexpr int kQueuedNewest = 30;
constexpr int kQueuedLossless = 2000;  // and of parts, of which a frame may have a hundred

// Changes of the reason alone are told at most this often: some alternate from frame to frame.
constexpr milliseconds kReasonPeriod(200);

// How often a keyframe that runs beside is looked after while no frame comes.
constexpr milliseconds kKeyframePeriod(3), kNever(60'000);

// A map that was just made leaves within this time, or not at all.
constexpr std::chrono::seconds kLastSend(5);

}  // namespace

MappingServer::MappingServer(const ServerConfig& config, Bus& bus, OnChange on_change)
    : config_(config),
      bus_(bus),
      on_change_(std::move(on_change)),
      server_epoch_(now_us()),
      inbox_(config.input, static_cast<std::size_t>(std::max(config.max_queued_mib, 1)) << 20),
      parts_([this](const std::string& camera, Bytes frame, bool may_wait) {
        inbox_.put({camera, ChannelKind::kFeatures}, frame, may_wait);
      }),
      mapper_(config),
      maps_({config.part_bytes(), config.map_bytes_per_s}),
      board_(server_epoch_),
      next_status_(Clock::now()),
      next_reason_(Clock::now()) {
  if (!config.camera.empty()) select_camera(config.camera);
  subscribe(config);
  thread_ = std::thread(&MappingServer::run, this);
}

MappingServer::~MappingServer() {
  stop();
  bus_.unsubscribe_all();
}

void MappingServer::subscribe(const ServerConfig& config) {
  const int max_queued = config.input == InputMode::kLossless ? kQueuedLossless : kQueuedNewest;
  const auto queued = [max_queued](ChannelKind kind) {
    return kind == ChannelKind::kFeatures || Inbox::each_counts(kind) ? kQueuedLossless
                                                                      : max_queued;
  };
  for (const ChannelKind kind :
       {ChannelKind::kCalibration, ChannelKind::kImage, ChannelKind::kFeatures,
        ChannelKind::kMeasurement, ChannelKind::kRelativeRequest, ChannelKind::kMapRequest})
    bus_.subscribe(channel_pattern(config.camera, kind), queued(kind),
                   [this](const std::string& channel, Bytes bytes) { receive(channel, bytes); });
  if (config.image_channel.empty()) return;
  bus_.subscribe(literal_pattern(config.image_channel), max_queued,
                 [this](const std::string&, Bytes bytes) {
                   inbox_.put({config_.camera, ChannelKind::kImage}, bytes);
                 });
}

// In the receiving thread: nothing but moving bytes, and putting parts together.
void MappingServer::receive(const std::string& channel, Bytes bytes) {
  const std::optional<Channel> parsed = parse_channel(channel);
  if (!parsed) {
    ++bad_channels_;
    return;
  }
  if (parsed->kind == ChannelKind::kFeatures)
    parts_.take(parsed->camera, bytes, Clock::now());
  else
    inbox_.put(*parsed, bytes);
}

void MappingServer::run() {
  while (!stopping_) guarded([this] { take_turn(); });
  guarded([this] { adopt_keyframe(true); });
  const Clock::time_point give_up = Clock::now() + kLastSend;
  guarded([&] {
    for (auto next = send_parts(); next && *next < give_up; next = send_parts())
      std::this_thread::sleep_until(*next);
  });
  board_.note_parts_left(maps_.drop_all());
  board_.note_stopping();
  guarded([this] {
    const status_t last = publish_status(true);
    if (on_change_) on_change_(last);
  });
}

// Memory, or a fault of ours or of on_change: told, and the server goes on.
template <class Action>
void MappingServer::guarded(Action action) {
  try {
    action();
  } catch (const std::exception& error) {
    board_.note_fault(error.what());
  }
}

void MappingServer::take_turn() {
  if (Clock::now() >= next_status_) publish_status(true);
  const Clock::time_point deadline = std::min(
      {next_status_, send_parts().value_or(next_status_),
       Clock::now() + std::chrono::duration_cast<Clock::duration>(PartCollector::kSilence) / 2,
       Clock::now() + (maps_beside_ ? kKeyframePeriod : kNever)});
  const std::optional<Received> message = inbox_.take(deadline);
  if (!message) {
    parts_.give_up_silent(Clock::now());
    return adopt_keyframe(false);
  }
  if (message->channel.kind == ChannelKind::kCalibration)
    take_calibration(*message);
  else if (message->channel.kind == ChannelKind::kMeasurement)
    take_measurement(*message);
  else if (message->channel.kind == ChannelKind::kRelativeRequest)
    take_request(*message);
  else if (message->channel.kind == ChannelKind::kMapRequest)
    take_map_request(*message);
  else
    take_frame(*message);
  tell_changes();
}

void MappingServer::take_calibration(const Received& message) {
  const CameraMapper::Taken taken = mapper_.take_calibration(message.channel.camera, message.bytes);
  if (taken.reason != Reason::kNone) board_.note_reason(taken.reason, taken.detail);
}

void MappingServer::take_measurement(const Received& message) {
  const auto taken = mapper_.take_measurement(message.channel.camera, message.bytes);
  if (taken.reason != Reason::kNone) board_.note_measurement(taken.reason, taken.detail);
}

// One that cannot be read has nobody to be told.
template <class Request>
std::optional<Request> MappingServer::read_request(const Received& message,
                                                   Decoded<Request> (*decode)(Bytes)) {
  Decoded<Request> request = decode(message.bytes);
  if (request.ok()) request.detail = camera_problem(request.value.camera, message.channel.camera);
  if (request.detail.empty()) return std::move(request.value);
  board_.note_measurement(Reason::kMalformedMessage, request.detail);
  return std::nullopt;
}

void MappingServer::take_request(const Received& message) {
  const auto request = read_request(message, decode_relative_request);
  if (!request) return;
  RelativeAnswer answer = mapper_.answer(*request);
  answer.time_us = now_us();
  answer.origin = {server_epoch_, request->camera};
  send(channel_name(request->camera, ChannelKind::kRelative), encode(to_message(answer)));
}

void MappingServer::take_map_request(const Received& message) {
  const auto request = read_request(message, decode_map_request);
  if (!request) return;
  maps_.answer(*request, Clock::now());
  parts_wait_ = true;
}

void MappingServer::take_frame(const Received& message) {
  CameraMapper::Mapped mapped;
  try {
    mapped = map_frame(message);
  } catch (const std::exception& error) {
    mapped.result.rejected = true;
    mapped.result.reason = Reason::kInternalError;
    mapped.result.detail = error.what();
  }
  // Every frame is counted once, so that who waits for an answer to each does not wait for ever.
  board_.note_frame(mapped.result, message.time, Clock::now());
  if (!mapped.result.rejected) last_time_us_ = mapped.result.time_us;
  if (mapped.update) publish_map(*mapped.update, last_time_us_);
  maps_beside_ = mapper_.maps_beside();
}

void MappingServer::adopt_keyframe(bool wait) {
  const std::optional<MapUpdate> update = mapper_.adopt_keyframe(wait);
  if (update) publish_map(*update, last_time_us_);
  maps_beside_ = mapper_.maps_beside();
}

void MappingServer::select_camera(const std::string& camera) {
  inbox_.select_camera(camera);
  parts_.select_camera(camera);
}

CameraMapper::Mapped MappingServer::map_frame(const Received& message) {
  mapper_.note_dropped(message.dropped_before);
  const bool was_open = mapper_.camera().empty();
  CameraMapper::Mapped mapped =
      mapper_.take_frame(message.channel, message.bytes, message.received_us);
  if (!mapped.new_calibration.empty()) {
    board_.note_new_map();
    board_.note_reason(Reason::kCalibrationChanged, mapped.new_calibration);
    tell_changes();  // before the frame has its own word
  }
  if (was_open && !mapper_.camera().empty()) select_camera(mapper_.camera());
  if (!mapped.result.rejected) {
    const PublishedPose pose{{server_epoch_, mapper_.camera()}, mapped.result};
    send(channel_name(mapper_.camera(), ChannelKind::kPose), encode(to_message(pose)));
    const PublishedDecision decision{pose.origin, decision_of(mapped.result)};
    send(channel_name(mapper_.camera(), ChannelKind::kDecision), encode(to_message(decision)));
  }
  return mapped;
}

void MappingServer::publish_map(const MapUpdate& update, std::int64_t time_us) {
  maps_.publish(to_message(update, {server_epoch_, mapper_.camera()}, time_us),
                channel_name(mapper_.camera(), ChannelKind::kMap));
  parts_wait_ = true;
}

std::optional<MappingServer::Clock::time_point> MappingServer::send_parts() {
  const auto next = maps_.send_due(
      Clock::now(), [this](const std::string& channel, const std::vector<std::uint8_t>& bytes) {
        send(channel, bytes);
        board_.note_part_sent();
      });
  parts_wait_ = next.has_value();
  return next;
}

void MappingServer::tell_changes() {
  const StatusBoard::Headline headline = board_.headline();
  if (headline == told_) return;
  const Clock::time_point now = Clock::now();
  if (headline.first == told_.first && now < next_reason_) return;
  told_ = headline;
  next_reason_ = now + kReasonPeriod;
  const status_t status = publish_status(false);
  if (on_change_) on_change_(status);
}

status_t MappingServer::publish_status(bool new_period) {
  const Inbox::Counts counts = inbox_.counts();
  const Clock::time_point now = Clock::now();
  if (new_period)
    next_status_ = now + std::chrono::duration_cast<Clock::duration>(
                             std::chrono::duration<double>(config_.status_period_s));
  const status_t status = board_.make(
      mapper_.camera(),
      {counts.frames, counts.dropped, counts.foreign, bad_channels_,
       mapper_.calibration_is_guessed(), parts_.counts(), mapper_.measurements(),
       counts.measurements_dropped, maps_.map().seq(), maps_.map().digest(), maps_.counts()},
      mapper_.streams(), mapper_.statistics(), now, new_period);
  const std::string camera = mapper_.camera().empty() ? std::string(kNoCamera) : mapper_.camera();
  send(channel_name(camera, ChannelKind::kStatus), encode(status));
  return status;
}

void MappingServer::send(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  bool sent = false;
  try {
    sent = bus_.publish(channel, bytes);
  } catch (const std::exception&) {
    // Lost, as on a network.
  }
  if (!sent) board_.note_send_failure();
}

bool MappingServer::wait_until_idle(milliseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
  while (inbox_.wait_until_idle(deadline) && Clock::now() < deadline) {
    if (!parts_wait_ && !maps_beside_) return true;
    std::this_thread::sleep_for(milliseconds(1));
  }
  return false;
}

void MappingServer::stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  inbox_.close();
  thread_.join();
}

std::string MappingServer::write_results(const std::filesystem::path& folder) const {
  return mapper_.write_results(folder);
}

}  // namespace eifmap
