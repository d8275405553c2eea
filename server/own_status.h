// What the server says of itself on eifmap.server.status: while it maps no camera, and from then on
// once it has something to say that belongs to none that it maps.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <thread>

#include "bus/bus.h"
#include "server/status_board.h"
#include "wire/channel.h"

namespace eifmap {

class OwnStatus {
 public:
  // Told of each refusal of another camera, and of the stop, in a thread of its own.
  using OnChange = std::function<void(const status_t&)>;

  // Publishes every `period_s` from a thread of its own; the bus must outlive it.
  OwnStatus(double period_s, Bus& bus, std::int64_t server_epoch, OnChange on_change);
  ~OwnStatus();
  OwnStatus(const OwnStatus&) = delete;
  OwnStatus& operator=(const OwnStatus&) = delete;

  // For any thread:
  void note_bad_channel();
  void note_commands(const CommandDesk::Counts& counts);  // to the server as a whole
  void note_camera();  // one more is mapped, and has a status of its own
  // A message of a camera that is not mapped, and why.
  void refuse(const std::string& camera, bool is_frame, Reason reason, const std::string& detail);
  // Of a camera that is not mapped: nothing can be done with it.
  void note_lost_measurement();

  status_t now();

  // As CameraLane's.
  void begin_stop();
  void end();

 private:
  using Clock = std::chrono::steady_clock;

  void run();
  bool has_something_to_say() const;
  void publish(std::unique_lock<std::mutex>& lock, bool new_period, bool is_news);
  status_t make_status(bool new_period);

  const Clock::duration period_;
  Bus& bus_;
  const OnChange on_change_;
  std::mutex mutex_;
  std::condition_variable changed_;
  StatusBoard board_;
  StatusBoard::Counts counts_;
  std::int64_t mapped_ = 0, lost_measurements_ = 0;
  std::set<std::string> refused_;  // cameras
  bool has_news_ = false, stopping_ = false;
  std::thread thread_;
};

}  // namespace eifmap
