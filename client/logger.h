// Writes what a server publishes into a folder: trajectory.tum (the tracked poses, the same text as
// the server's own), poses.jsonl and status.jsonl (everything, a line a message), and in the end
// map.ply from the map's updates.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "bus/bus.h"
#include "convert/map_assembler.h"
#include "convert/pose_message.h"
#include "convert/status_message.h"

namespace eifmap {

class Logger {
 public:
  using Clock = std::chrono::steady_clock;

  struct Opened;
  // Makes the folder and subscribes on the bus, which must outlive the logger. `camera`: "" takes
  // the first that speaks, and only that one.
  static Opened open(const std::filesystem::path& folder, const std::string& camera, Bus& bus);

  ~Logger();
  Logger(const Logger&) = delete;
  Logger& operator=(const Logger&) = delete;

  struct Counts {
    std::int64_t poses = 0, tracked = 0, map_parts = 0, statuses = 0, malformed = 0;
  };
  // These from the thread that calls bus.receive().
  const Counts& counts() const { return counts_; }
  const MapAssembler& map() const { return map_; }
  const status_t& last_status() const { return last_status_; }  // zeros before the first
  bool server_stopped() const { return last_status_.state == status_t::STATE_STOPPING; }
  Clock::time_point last_message() const { return last_message_; }  // of any kind; first: open()

  // Writes map.ply. Returns "" or what went wrong since open().
  std::string finish();

 private:
  Logger(const std::filesystem::path& folder, const std::string& camera, Bus& bus);

  void receive_pose(const std::string& channel, Bytes bytes);
  void receive_status(const std::string& channel, Bytes bytes);
  void receive_map(const std::string& channel, Bytes bytes);
  bool is_mine(const std::string& channel);

  std::filesystem::path folder_;
  std::string camera_;
  Bus& bus_;
  std::ofstream trajectory_, poses_, statuses_;
  MapAssembler map_;
  Counts counts_;
  status_t last_status_{};
  Clock::time_point last_message_ = Clock::now();
};

struct Logger::Opened {
  std::unique_ptr<Logger> logger;
  std::string problem;  // "" when there is a logger
};

}  // namespace eifmap
