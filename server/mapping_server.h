// The live server: messages in from a bus; of every camera that is heard poses, map parts and
// status out.
//
//   receiving thread (the caller of bus.receive) -> CameraLane, one a camera -> bus.publish
//
// The receiving thread finds the lane by the camera in a channel's name and moves the bytes there,
// no more, so that it is always back for the next message, whoever's that is. All cameras of a kind
// of message share one queue of the bus (a bus takes no subscriptions while it receives): what one
// of them floods, it floods before the others only while the receiving thread has no core.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "bus/bus.h"
#include "server/camera_lane.h"
#include "server/config.h"
#include "server/own_status.h"
#include "server/server_commands.h"

namespace eifmap {

class MappingServer {
 public:
  // Told of each change of a camera's state or reason, of cameras that are refused, and of the
  // stop; one call at a time, in threads of the server.
  using OnChange = std::function<void(const status_t&)>;
  // Told of the steps of each camera's mapper, in several threads; see CameraMapper.
  using OnStep = std::function<void(const std::string& camera, std::string_view step, bool begins)>;

  // Subscribes on the bus, which must outlive the server and whose receive() somebody must call.
  // Maps config.camera; where that is empty, every camera of which a calibration, an image or
  // features come, up to config.max_cameras. Construct and destroy it while nobody is in
  // bus.receive(). Throws std::invalid_argument with config.problem(), or what is wrong with the
  // file of the secret.
  MappingServer(const ServerConfig& config, Bus& bus, OnChange on_change = {}, OnStep on_step = {},
                Results results = Results::kKept);
  ~MappingServer();
  MappingServer(const MappingServer&) = delete;
  MappingServer& operator=(const MappingServer&) = delete;

  // Whether shutdown was commanded, and who commanded has had the time to hear the reply.
  bool told_to_stop() const { return commands_.told_to_stop(); }

  // Waits until every message received so far is mapped and the maps are published. False at the
  // time-out.
  bool wait_until_idle(std::chrono::milliseconds timeout);

  // The server's own, without a camera, and the last one of each camera; for any thread, and
  // without waiting for any that maps.
  std::vector<status_t> statuses();

  // Every camera's lane finishes the frame in work, publishes what is left of its map and a last
  // status, and ends, all at the same time. Messages that still wait are not mapped.
  void stop();

  // After stop(), and where they are kept: whether there are any results. And them written, of one
  // camera into the folder itself, of several into one by the name of each; returns "" or what went
  // wrong.
  bool has_results() const;
  std::string write_results(const std::filesystem::path& folder) const;

 private:
  void subscribe();
  // In the receiving thread:
  void receive(const std::string& channel, Bytes bytes);
  void route(const Channel& channel, Bytes bytes);
  CameraLane* lane_of(const Channel& channel, Bytes bytes);
  CameraLane* add_lane(const std::string& camera, bool is_frame);
  std::unique_ptr<CameraLane> make_lane(const std::string& camera);

  std::vector<ServerCommands::Camera> commanded() const;
  std::vector<CameraLane*> lanes() const;
  std::vector<const CameraLane*> lanes_with_results() const;
  void tell(const status_t& status);

  const ServerConfig config_;
  Bus& bus_;
  const OnChange on_change_;
  const OnStep on_step_;
  const Results results_;
  const CommandAccess access_;
  std::mutex tell_mutex_;  // held while on_change_ is called
  mutable std::mutex lanes_mutex_;
  std::map<std::string, std::unique_ptr<CameraLane>> lanes_;  // by camera; none ever goes
  bool stopping_ = false;                                     // no more lanes
  OwnStatus own_status_;                                      // after what its thread uses: tell()
  ServerCommands commands_;                                   // and after that, too
};

}  // namespace eifmap
