// One camera of the live server, from its messages to its poses, map parts and status, which no
// other camera's lane has a share in: its own budget of waiting input, its own map, its own thread.
//
//   receiving thread -> Inbox -> mapping thread -> bus.publish
//
// The mapping thread tracks; keyframes go into the map in a third one (keyframe_worker.h).
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "bus/bus.h"
#include "server/camera_commands.h"
#include "server/camera_mapper.h"
#include "server/command_desk.h"
#include "server/config.h"
#include "server/inbox.h"
#include "server/map_publisher.h"
#include "server/order_queue.h"
#include "server/part_collector.h"
#include "server/status_board.h"

namespace eifmap {

class CameraLane {
 public:
  using Clock = std::chrono::steady_clock;
  // Told of each change of state or reason and of the stop, in the mapping thread.
  using OnChange = std::function<void(const status_t&)>;
  // Told of the mapper's steps, in the threads that take them; see CameraMapper.
  using OnStep = std::function<void(std::string_view step, bool begins)>;

  // Of the camera that the configuration names. Starts the mapping thread. The bus, on which it
  // only publishes, must outlive it. Throws std::invalid_argument with config.problem().
  CameraLane(const ServerConfig& config, Bus& bus, const CommandAccess& access, OnChange on_change,
             OnStep on_step, Results results = Results::kKept);
  ~CameraLane();
  CameraLane(const CameraLane&) = delete;
  CameraLane& operator=(const CameraLane&) = delete;

  // A message of this camera: moves its bytes, and puts parts together, no more. From one thread.
  // `may_wait`: for room, when lossless; else what has none is dropped and counted.
  void receive(ChannelKind kind, Bytes bytes, bool may_wait);

  // Has it done in the mapping thread, between two frames, before those that wait. From any thread.
  // The future has std::future_error where the lane ends before that, or too much waits.
  std::future<CommandOutcome> command(std::function<CommandOutcome(CommandTarget&)> action);

  // Waits until every message received so far is mapped and the map is published. False at the
  // time-out.
  bool wait_until_idle(Clock::time_point deadline);

  // The mapping thread finishes the frame in work, publishes what is left of the map and a last
  // status, and ends, for which end() waits. Messages that still wait are not mapped.
  void begin_stop();
  void end();

  const std::string& camera() const { return camera_; }
  status_t last_status() const;  // that was published; for any thread

  // After end(): whether there are any results. And them written; returns "" or what went wrong.
  bool has_results() const { return mapper_.has_results(); }
  std::string write_results(const std::filesystem::path& folder) const;

 private:
  // In the mapping thread:
  void run();
  template <class Action>
  void guarded(Action action);
  void take_turn();
  void order(OrderQueue::Order order);
  void do_orders();
  void take_message(const Received& message);
  void take_calibration(const Received& message);
  void take_measurement(const Received& message);
  template <class Request>
  std::optional<Request> read_request(const Received& message, Decoded<Request> (*decode)(Bytes));
  void take_request(const Received& message);
  void take_map_request(const Received& message);
  void take_frame(const Received& message);
  void leave_out(const Received& message);
  CameraMapper::Mapped map_frame(const Received& message);
  void resume();
  void tell_refused_files();
  void publish_map(const MapUpdate& update, std::int64_t time_us);
  void publish_saved();
  void adopt_keyframe(bool wait);
  void tell_changes();
  status_t publish_status(bool new_period);
  std::optional<Clock::time_point> send_parts();
  void send(ChannelKind kind, const std::vector<std::uint8_t>& bytes);

  const std::string camera_;
  const Clock::duration status_period_;
  Bus& bus_;
  const OnChange on_change_;
  const Origin origin_;
  Inbox inbox_;
  PartCollector parts_;
  CameraMapper mapper_;
  MapPublisher maps_;
  std::deque<map_part_t> unsaved_;  // updates that wait until what they acknowledge is on the disk
  StatusBoard board_;
  std::int64_t last_time_us_ = 0;  // of the frame mapped last
  mutable std::mutex last_status_mutex_;
  status_t last_status_{};
  CameraCommands commands_;
  CommandDesk desk_;
  OrderQueue orders_;
  StatusBoard::Headline told_{};
  Clock::time_point next_status_, next_reason_;
  std::atomic<bool> parts_wait_ = false, maps_beside_ = false, saves_ = false, stopping_ = false;
  std::thread thread_;
};

}  // namespace eifmap
