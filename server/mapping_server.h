// The live server: messages in from a bus, poses, map parts and status out.
//
//   receiving thread (the caller of bus.receive) -> Inbox -> mapping thread -> bus.publish
//
// The mapping thread tracks; keyframes go into the map in a third one (keyframe_worker.h).
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "bus/bus.h"
#include "server/camera_mapper.h"
#include "server/config.h"
#include "server/inbox.h"
#include "server/map_publisher.h"
#include "server/part_collector.h"
#include "server/status_board.h"

namespace eifmap {

class MappingServer {
 public:
  // Told of each change of state or reason and of the stop, in the mapping thread.
  using OnChange = std::function<void(const status_t&)>;

  // Subscribes on the bus, which must outlive the server and whose receive() somebody must call,
  // and starts the mapping thread. Construct and destroy it while nobody is in bus.receive().
  // Throws std::invalid_argument with config.problem().
  MappingServer(const ServerConfig& config, Bus& bus, OnChange on_change = {});
  ~MappingServer();
  MappingServer(const MappingServer&) = delete;
  MappingServer& operator=(const MappingServer&) = delete;

  // Waits until every message received so far is mapped and the map is published. False at the
  // time-out.
  bool wait_until_idle(std::chrono::milliseconds timeout);

  // Finishes the frame in work, publishes what is left of the map and a last status, and ends the
  // mapping thread. Messages that still wait are not mapped.
  void stop();

  // After stop(): whether there are any results. And them written; returns "" or what went wrong.
  bool has_results() const { return mapper_.has_results(); }
  std::string write_results(const std::filesystem::path& folder) const;

 private:
  using Clock = std::chrono::steady_clock;

  void subscribe(const ServerConfig& config);
  void receive(const std::string& channel, Bytes bytes);

  // In the mapping thread:
  void run();
  template <class Action>
  void guarded(Action action);
  void take_turn();
  void take_calibration(const Received& message);
  void take_measurement(const Received& message);
  template <class Request>
  std::optional<Request> read_request(const Received& message, Decoded<Request> (*decode)(Bytes));
  void take_request(const Received& message);
  void take_map_request(const Received& message);
  void take_frame(const Received& message);
  void select_camera(const std::string& camera);
  CameraMapper::Mapped map_frame(const Received& message);
  void publish_map(const MapUpdate& update, std::int64_t time_us);
  void adopt_keyframe(bool wait);
  void tell_changes();
  status_t publish_status(bool new_period);
  std::optional<Clock::time_point> send_parts();
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes);

  const ServerConfig config_;
  Bus& bus_;
  const OnChange on_change_;
  const std::int64_t server_epoch_;
  Inbox inbox_;
  PartCollector parts_;
  CameraMapper mapper_;
  MapPublisher maps_;
  StatusBoard board_;
  std::int64_t last_time_us_ = 0;  // of the frame mapped last
  StatusBoard::Headline told_{};
  Clock::time_point next_status_, next_reason_;
  std::atomic<std::int64_t> bad_channels_ = 0;
  std::atomic<bool> parts_wait_ = false, maps_beside_ = false, stopping_ = false;
  std::thread thread_;
};

}  // namespace eifmap
