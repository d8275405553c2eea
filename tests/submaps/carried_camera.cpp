#include "submaps/carried_camera.h"

#include <algorithm>
#include <cmath>

#include "geometry/similarity.h"

namespace eifmap::test {
namespace {

Room room_of(const Eigen::Vector3d& place) {
  constexpr double kHalf = 4;
  if (place.x() < kHalf) return Room::kA;
  return place.x() < RoomWorld::centre_of_b().x() - kHalf ? Room::kPassage : Room::kB;
}

}  // namespace

CarriedCamera::CarriedCamera(const RoomWorld& world, const MapperOptions& options,
                             KeyframeRunner* runner)
    : world_(world), mapper_(world.camera(), options) {
  if (runner) mapper_.set_keyframe_runner(runner, true);
}

FrameResult CarriedCamera::see(const Rigid3& world_from_camera) {
  FeatureFrame frame = world_.frame(world_from_camera, ++number_);
  frame.time_us = std::int64_t{100'000} * number_;
  truth_[frame.time_us] = world_from_camera;
  results_.push_back(mapper_.process(frame));
  if (results_.back().map_updated) take_update();
  judge(results_.back(), world_from_camera);
  return results_.back();
}

FrameResult CarriedCamera::covered(int frames) {
  for (int i = 0; i < frames; ++i) {
    FeatureFrame frame = world_.frame(RoomWorld::in_room(false, 0), ++number_);
    frame.time_us = std::int64_t{100'000} * number_;
    frame.keypoints.clear();
    frame.descriptors.clear();
    results_.push_back(mapper_.process(frame));
    if (results_.back().map_updated) take_update();
  }
  return results_.back();
}

FrameResult CarriedCamera::look_around(Room room, double from, double to, int frames) {
  for (int i = 0; i < frames; ++i)
    see(RoomWorld::in_room(room == Room::kB, from + (to - from) * i / frames));
  return results_.back();
}

FrameResult CarriedCamera::walk(double from, double to, int frames) {
  has_walked_ = true;
  for (int i = 0; i < frames; ++i)
    see(RoomWorld::on_the_way(from + (to - from) * i / frames, to < from));
  return results_.back();
}

void CarriedCamera::settle() {
  if (mapper_.settle()) take_update();
}

void CarriedCamera::take_update() {
  const MapUpdate update = mapper_.map_update();
  if (update.map_epoch < epoch_) problems_.emplace_back("an epoch is lower than the one before");
  if (update.map_epoch != epoch_ && update.base_seq != -1)
    problems_.emplace_back("an epoch does not begin with a whole map");
  if (update.map_epoch == epoch_ && update.base_seq != seq_)
    problems_.emplace_back("an update does not follow on from the one before");
  epoch_ = update.map_epoch;
  seq_ = update.seq;
  for (const std::string& problem : mapper_.audit()) problems_.push_back(problem);
}

void CarriedCamera::judge(const FrameResult& result, const Rigid3& truth) {
  if (has_walked_ || result.state != TrackingState::kTracking) return;
  const Room here = room_of(truth.translation);
  const auto [map, is_new] = room_of_map_.try_emplace(result.map_id, here);
  if (map->second != here) ++poses_elsewhere_;
}

CarriedCamera::Errors CarriedCamera::errors() const {
  const std::vector<TimedPose> trajectory = mapper_.final_trajectory();
  const auto n = static_cast<Eigen::Index>(trajectory.size());
  Errors errors;
  errors.frames = static_cast<int>(n);
  if (n < 3) return errors;
  Eigen::Matrix3Xd truth(3, n), estimate(3, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const TimedPose& pose = trajectory[static_cast<std::size_t>(k)];
    truth.col(k) = truth_.at(pose.time_us).translation;
    estimate.col(k) = pose.world_from_camera.translation;
  }
  const Similarity s = fit_similarity(truth, estimate);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double error = (truth.col(k) - s * Eigen::Vector3d(estimate.col(k))).norm();
    errors.rmse += error * error / static_cast<double>(n);
    errors.largest = std::max(errors.largest, error);
  }
  errors.rmse = std::sqrt(errors.rmse);
  return errors;
}

}  // namespace eifmap::test
