// Feature frames that come in parts, of any camera, made whole on their way to the inbox.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "convert/feature_parts.h"

namespace eifmap {

class PartCollector {
 public:
  using Clock = std::chrono::steady_clock;
  // Takes a feature frame as a message; called by one thread at a time, a camera's frames in the
  // order of their capture. `may_wait`: from take(), for room.
  using Deliver = std::function<void(const std::string& camera, Bytes frame, bool may_wait)>;

  explicit PartCollector(Deliver deliver) : deliver_(std::move(deliver)) {}

  // A message of a camera's feature channel. Whole frames are delivered at once, after what the
  // camera has in work. So is a message that is no good part: it is refused and counted where all
  // are.
  void take(const std::string& camera, Bytes message, Clock::time_point now);

  // Delivers, without what is missing, frames of which nothing has come for kSilence. Not while
  // another thread is in take(): then there is no silence. For any thread, best for the one that
  // has nothing else to do.
  void give_up_silent(Clock::time_point now);

  // From now on only parts of this camera are put together; of others the first part of each frame
  // is delivered as it is, to be counted. For any thread.
  void select_camera(const std::string& camera);

  // Of all frames that came in parts. For any thread; never waits for a delivery.
  FeatureAssembler::Counts counts() const;

  // Far above the time between two parts of one frame, on any link that is of use.
  static constexpr auto kSilence = std::chrono::milliseconds(200);
  // Put together at a time, before one is selected: who makes up names must not fill the memory.
  static constexpr std::size_t kMaxCameras = 16;

 private:
  struct Camera {
    FeatureAssembler assembler;
    Clock::time_point last_part;
  };

  void deliver(const std::string& camera, const std::vector<FeatureFrame>& frames, bool may_wait);
  void finish(const std::string& name, Camera& camera, bool may_wait);
  void note(const FeatureAssembler::Counts& before, const FeatureAssembler::Counts& after);
  void make_room();
  bool is_foreign(const std::string& camera) const;

  const Deliver deliver_;
  std::mutex work_mutex_;  // held during deliveries
  std::map<std::string, Camera> cameras_;
  mutable std::mutex state_mutex_;  // held for moments
  FeatureAssembler::Counts counts_;
  std::string selected_;
};

}  // namespace eifmap
