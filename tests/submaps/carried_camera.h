// A mapper whose camera is walked through two rooms, covered, and carried from one to the other;
// with the truth of every frame.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "mapper.h"
#include "support/room_world.h"

namespace eifmap::test {

enum class Room : std::uint8_t { kA, kPassage, kB };

class CarriedCamera {
 public:
  CarriedCamera(const RoomWorld& world, const MapperOptions& options,
                KeyframeRunner* runner = nullptr);

  // 10 images a second. Each returns what became of its last.
  FrameResult see(const Rigid3& world_from_camera);
  FrameResult covered(int frames);
  FrameResult look_around(Room room, double from, double to, int frames);  // rad
  FrameResult walk(double from, double to, int frames);  // of the way from A to B, ahead: 0 to 1
  // Waits for a job that runs, and adopts it.
  void settle();

  const std::vector<FrameResult>& results() const { return results_; }
  const Mapper& mapper() const { return mapper_; }
  // What was told of the map by updates: its epochs grew, and each began with a whole map.
  const std::vector<std::string>& problems() const { return problems_; }

  // Poses that were given in a map of the other room. Before the passage is walked, a map is of the
  // room that it was begun in.
  int poses_elsewhere() const { return poses_elsewhere_; }
  // Of the final trajectory, after a similarity transform: RMSE, the largest error (m), and of how
  // many frames it is.
  struct Errors {
    double rmse = 0, largest = 0;
    int frames = 0;
  };
  Errors errors() const;

 private:
  void take_update();
  void judge(const FrameResult& result, const Rigid3& truth);

  const RoomWorld& world_;
  Mapper mapper_;
  std::vector<FrameResult> results_;
  std::map<std::int64_t, Rigid3> truth_;      // by time
  std::map<std::int64_t, Room> room_of_map_;  // by map_id
  std::vector<std::string> problems_;
  std::int64_t epoch_ = -1, seq_ = -1;
  bool has_walked_ = false;
  int poses_elsewhere_ = 0;
  int number_ = 0;
};

}  // namespace eifmap::test
