// Writes what a server publishes into a folder: trajectory.tum (the tracked poses, in the end the
// same text as the server's own: in metres where a map has become metric), poses.jsonl and
// status.jsonl (everything, a line a message), decisions.jsonl and measurements.jsonl (for a
// replay), and in the end the map: its points in map.ply, what it is of in map.json.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bus/bus.h"
#include "convert/decision_message.h"
#include "convert/measurement_message.h"
#include "convert/pose_message.h"
#include "convert/status_message.h"
#include "eifmap/map_client.h"
#include "published_path.h"

namespace eifmap {

class Logger {
 public:
  using Clock = std::chrono::steady_clock;

  struct Opened;
  // Makes the folder and subscribes on the bus, which must outlive the logger. `camera`: "" takes
  // the first that is heard of, and only that one. Statuses: of the server that maps it, and before
  // that is known, of servers that have no camera yet.
  static Opened open(const std::filesystem::path& folder, const std::string& camera, Bus& bus);

  ~Logger();
  Logger(const Logger&) = delete;
  Logger& operator=(const Logger&) = delete;

  struct Counts {
    std::int64_t poses = 0, tracked = 0, map_parts = 0, statuses = 0, malformed = 0,
                 measurements = 0;
  };
  // These from the thread that calls bus.receive().
  const std::string& camera() const { return camera_; }  // that is logged; "" none yet
  Counts counts() const;
  const MapClient& map() const { return map_; }
  const status_t& last_status() const { return last_status_; }      // zeros before the first
  bool server_stopped() const { return server_stopped_; }           // the one logged
  Clock::time_point last_message() const { return last_message_; }  // that was taken; first: open()

  // To be called now and then, 10 times a second or more: asks the server for what is missing of
  // the map.
  void tick() { map_.tick(); }

  // Writes map.ply and map.json, and trajectory.tum anew where a map has become metric. Returns ""
  // or what went wrong since open().
  std::string finish();

 private:
  Logger(const std::filesystem::path& folder, const std::string& camera, Bus& bus);

  void receive_pose(const std::string& channel, Bytes bytes);
  void receive_status(const std::string& channel, Bytes bytes);
  void receive_decision(const std::string& channel, Bytes bytes);
  void receive_measurement(const std::string& channel, Bytes bytes);
  void write(const NamedMeasurement& measurement);
  void receive_map(const std::string& channel, Bytes bytes);
  bool is_mine(const std::string& channel);
  void take(const Origin& origin);
  std::string finish_trajectory();
  std::string write_map_facts() const;

  std::filesystem::path folder_;
  std::string camera_;
  Bus& bus_;
  std::ofstream trajectory_, poses_, statuses_, decisions_, measurements_;
  std::map<std::int64_t, PublishedPath> paths_;  // by the server's run
  MapClient map_;
  Counts counts_;                     // but for the map's
  std::set<MeasurementId> measured_;  // written; a datagram may come twice
  // Until it is known which camera is logged; few come before the first pose.
  std::vector<NamedMeasurement> early_;
  std::optional<std::int64_t> server_epoch_;  // of the server that maps the camera
  status_t last_status_{};
  bool server_stopped_ = false;
  Clock::time_point last_message_ = Clock::now();
};

struct Logger::Opened {
  std::unique_ptr<Logger> logger;
  std::string problem;  // "" when there is a logger
};

}  // namespace eifmap
