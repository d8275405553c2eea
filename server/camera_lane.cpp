#include "server/camera_lane.h"

#include <algorithm>
#include <utility>

#include "convert/decision_message.h"
#include "convert/map_message.h"
#include "wire/clock.h"

namespace eifmap {
namespace {

using std::chrono::milliseconds;

// Changes of the reason alone are told at most this often: some alternate from frame to frame.
constexpr milliseconds kReasonPeriod(200);

// How often a keyframe that runs beside is looked after while no frame comes.
constexpr milliseconds kKeyframePeriod(3), kNever(60'000);  // and a map that is being saved

// A map that was just made leaves within this time, or not at all.
constexpr std::chrono::seconds kLastSend(5);

}  // namespace

CameraLane::CameraLane(const ServerConfig& config, Bus& bus, const CommandAccess& access,
                       OnChange on_change, OnStep on_step, Results results)
    : camera_(config.camera),
      status_period_(std::chrono::duration_cast<Clock::duration>(
          std::chrono::duration<double>(config.status_period_s))),
      bus_(bus),
      on_change_(std::move(on_change)),
      origin_{access.server_epoch, config.camera},
      inbox_(config.input, static_cast<std::size_t>(std::max(config.max_queued_mib, 1)) << 20),
      parts_([this](Bytes frame, bool may_wait) {
        inbox_.put({camera_, ChannelKind::kFeatures}, frame, may_wait);
      }),
      mapper_(config),
      maps_({config.part_bytes(), config.map_bytes_per_s}),
      board_(access.server_epoch),
      commands_(
          access.server_epoch, mapper_, maps_, board_,
          [this](ChannelKind kind, const std::vector<std::uint8_t>& bytes) { send(kind, bytes); }),
      desk_(camera_, access, commands_),
      next_status_(Clock::now()),
      next_reason_(Clock::now()) {
  if (on_step) mapper_.set_step_observer(std::move(on_step));
  if (results == Results::kNone) mapper_.keep_no_results();
  thread_ = std::thread(&CameraLane::run, this);
}

CameraLane::~CameraLane() {
  begin_stop();
  end();
}

void CameraLane::receive(ChannelKind kind, Bytes bytes, bool may_wait) {
  if (kind == ChannelKind::kCommand)
    order([this, command = std::vector<std::uint8_t>(bytes.begin(), bytes.end())] {
      if (const auto reply = desk_.answer(command, Clock::now())) send(ChannelKind::kReply, *reply);
    });
  else if (kind == ChannelKind::kFeatures)
    parts_.take(bytes, Clock::now(), may_wait);
  else
    inbox_.put({camera_, kind}, bytes, may_wait);
}

// Where the inbox is full, and this does not go in, its taker does not sleep either.
void CameraLane::order(OrderQueue::Order order) {
  if (orders_.push(std::move(order))) inbox_.put({camera_, ChannelKind::kCommand}, {}, false);
}

std::future<CommandOutcome> CameraLane::command(
    std::function<CommandOutcome(CommandTarget&)> action) {
  const auto task = std::make_shared<std::packaged_task<CommandOutcome()>>(
      [this, action = std::move(action)] { return action(commands_); });
  std::future<CommandOutcome> outcome = task->get_future();
  order([task] { (*task)(); });
  return outcome;
}

void CameraLane::do_orders() {
  const std::vector<OrderQueue::Order> orders = orders_.take();
  if (orders.empty()) return;
  for (const OrderQueue::Order& order : orders) {
    guarded(order);
    const std::optional<MapUpdate> update = mapper_.take_commanded();
    if (update) publish_map(*update, last_time_us_);
  }
  maps_beside_ = mapper_.maps_beside();
  parts_wait_ = true;  // of a snapshot, maybe
  tell_changes();
}

void CameraLane::run() {
  while (!stopping_) guarded([this] { take_turn(); });
  orders_.close();
  guarded([this] { adopt_keyframe(true); });
  guarded([this] {
    mapper_.wait_until_saved();
    publish_saved();
  });
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
void CameraLane::guarded(Action action) {
  try {
    action();
  } catch (const std::exception& error) {
    board_.note_fault(error.what());
  }
}

void CameraLane::take_turn() {
  publish_saved();
  do_orders();
  if (Clock::now() >= next_status_) publish_status(true);
  const Clock::time_point deadline = std::min(
      {next_status_, send_parts().value_or(next_status_),
       Clock::now() + std::chrono::duration_cast<Clock::duration>(PartCollector::kSilence) / 2,
       Clock::now() + (maps_beside_ || saves_ ? kKeyframePeriod : kNever)});
  const std::optional<Received> message = inbox_.take(deadline);
  if (!message) {
    parts_.give_up_silent(Clock::now());
    return adopt_keyframe(false);
  }
  take_message(*message);
  tell_changes();
}

void CameraLane::take_message(const Received& message) {
  switch (message.channel.kind) {
    case ChannelKind::kCalibration:
      return take_calibration(message);
    case ChannelKind::kMeasurement:
      return take_measurement(message);
    case ChannelKind::kRelativeRequest:
      return take_request(message);
    case ChannelKind::kMapRequest:
      return take_map_request(message);
    case ChannelKind::kCommand:
      return;  // it woke us, for do_orders()
    default:
      return take_frame(message);
  }
}

void CameraLane::take_calibration(const Received& message) {
  const Taken taken = mapper_.take_calibration(message.channel.camera, message.bytes);
  if (taken.reason != Reason::kNone) board_.note_reason(taken.reason, taken.detail);
  resume();
}

// Before the first frame: whoever looks at the map need not wait for one.
void CameraLane::resume() {
  const std::optional<MapUpdate> update = mapper_.resume();
  tell_refused_files();
  if (!update) return;
  board_.note_resumed(update->map_id, mapper_.statistics());
  publish_map(*update, 0);
}

void CameraLane::tell_refused_files() {
  for (const Taken& file : mapper_.take_refused_files()) {
    board_.note_reason(file.reason, file.detail);
    tell_changes();
  }
}

void CameraLane::take_measurement(const Received& message) {
  const auto taken = mapper_.take_measurement(message.channel.camera, message.bytes);
  if (taken.reason != Reason::kNone) board_.note_measurement(taken.reason, taken.detail);
}

// One that cannot be read has nobody to be told.
template <class Request>
std::optional<Request> CameraLane::read_request(const Received& message,
                                                Decoded<Request> (*decode)(Bytes)) {
  Decoded<Request> request = decode(message.bytes);
  if (request.ok()) request.detail = camera_problem(request.value.camera, message.channel.camera);
  if (request.detail.empty()) return std::move(request.value);
  board_.note_measurement(Reason::kMalformedMessage, request.detail);
  return std::nullopt;
}

void CameraLane::take_request(const Received& message) {
  const auto request = read_request(message, decode_relative_request);
  if (!request) return;
  RelativeAnswer answer = mapper_.answer(*request);
  answer.time_us = now_us();
  answer.origin = origin_;
  send(ChannelKind::kRelative, encode(to_message(answer)));
}

void CameraLane::take_map_request(const Received& message) {
  const auto request = read_request(message, decode_map_request);
  if (!request) return;
  maps_.answer(*request, Clock::now());
  parts_wait_ = true;
}

// Its number is no gap, and of what came before it is told, too.
void CameraLane::leave_out(const Received& message) {
  mapper_.note_dropped(message.dropped_before + 1);
  board_.note_paused_frame();
  adopt_keyframe(false);
}

void CameraLane::take_frame(const Received& message) {
  if (board_.is_paused()) return leave_out(message);
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

void CameraLane::adopt_keyframe(bool wait) {
  const std::optional<MapUpdate> update = mapper_.adopt_keyframe(wait);
  if (update) publish_map(*update, last_time_us_);
  maps_beside_ = mapper_.maps_beside();
}

CameraMapper::Mapped CameraLane::map_frame(const Received& message) {
  mapper_.note_dropped(message.dropped_before);
  CameraMapper::Mapped mapped =
      mapper_.take_frame(message.channel, message.bytes, message.received_us);
  tell_refused_files();
  if (!mapped.new_calibration.empty()) {
    board_.note_new_map();
    board_.note_reason(Reason::kCalibrationChanged, mapped.new_calibration);
    tell_changes();  // before the frame has its own word
  }
  if (!mapped.result.rejected) {
    const PublishedPose pose{origin_, mapped.result};
    send(ChannelKind::kPose, encode(to_message(pose)));
    const PublishedDecision decision{origin_, decision_of(mapped.result)};
    send(ChannelKind::kDecision, encode(to_message(decision)));
  }
  return mapped;
}

void CameraLane::publish_map(const MapUpdate& update, std::int64_t time_us) {
  unsaved_.push_back(to_message(update, origin_, time_us));
  saves_ = true;
  mapper_.save_maps();
  publish_saved();
}

// What an update acknowledges outlives the process: it leaves when it is on the disk, or cannot be.
void CameraLane::publish_saved() {
  const std::optional<MapSaver::State> saved = mapper_.saved();
  while (!unsaved_.empty() && (!saved || unsaved_.front().seq <= saved->seq)) {
    const map_part_t update = std::move(unsaved_.front());
    unsaved_.pop_front();
    maps_.publish(update, channel_name(camera_, ChannelKind::kMap));
    parts_wait_ = true;
  }
  saves_ = !unsaved_.empty();
  if (!saved || !board_.note_saved(*saved)) return;
  const status_t status = publish_status(false);
  if (on_change_) on_change_(status);
}

std::optional<CameraLane::Clock::time_point> CameraLane::send_parts() {
  const auto next = maps_.send_due(
      Clock::now(), [this](const std::string&, const std::vector<std::uint8_t>& bytes) {
        send(ChannelKind::kMap, bytes);
        board_.note_part_sent();
      });
  parts_wait_ = next.has_value();
  return next;
}

void CameraLane::tell_changes() {
  const StatusBoard::Headline headline = board_.headline();
  if (headline == told_) return;
  const Clock::time_point now = Clock::now();
  if (headline.first == told_.first && now < next_reason_) return;
  told_ = headline;
  next_reason_ = now + kReasonPeriod;
  const status_t status = publish_status(false);
  if (on_change_) on_change_(status);
}

status_t CameraLane::publish_status(bool new_period) {
  const Inbox::Counts counts = inbox_.counts();
  const Clock::time_point now = Clock::now();
  if (new_period) next_status_ = now + status_period_;
  const status_t status =
      board_.make(camera_,
                  {counts.frames, counts.dropped, /*foreign_frames=*/0, /*bad_channels=*/0,
                   mapper_.calibration_is_guessed(), parts_.counts(), mapper_.measurements(),
                   counts.measurements_dropped, maps_.map().seq(), maps_.map().digest(),
                   maps_.counts(), desk_.counts()},
                  mapper_.streams(), mapper_.statistics(), now, new_period);
  send(ChannelKind::kStatus, encode(status));
  const std::lock_guard lock(last_status_mutex_);
  last_status_ = status;
  return status;
}

void CameraLane::send(ChannelKind kind, const std::vector<std::uint8_t>& bytes) {
  bool sent = false;
  try {
    sent = bus_.publish(channel_name(camera_, kind), bytes);
  } catch (const std::exception&) {
    // Lost, as on a network.
  }
  if (!sent) board_.note_send_failure();
}

bool CameraLane::wait_until_idle(Clock::time_point deadline) {
  while (inbox_.wait_until_idle(deadline) && Clock::now() < deadline) {
    // In the order in which work goes on: each is told of before what it came from is done.
    if (!maps_beside_ && !saves_ && !parts_wait_) return true;
    std::this_thread::sleep_for(milliseconds(1));
  }
  return false;
}

status_t CameraLane::last_status() const {
  const std::lock_guard lock(last_status_mutex_);
  return last_status_;
}

void CameraLane::begin_stop() {
  stopping_ = true;
  inbox_.close();
}

void CameraLane::end() {
  if (thread_.joinable()) thread_.join();
}

std::string CameraLane::write_results(const std::filesystem::path& folder) const {
  return mapper_.write_results(folder);
}

}  // namespace eifmap
