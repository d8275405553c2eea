#include "degenerate/run.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "features/front_end.h"
#include "mapper.h"
#include "sequence/trajectory_error.h"

namespace eifmap::test {
namespace {

double seconds(std::int64_t time_us) {
  return 1e-6 * static_cast<double>(time_us);
}

void take_update(const MapUpdate& update, CaseRun& run) {
  if (update.map_id == 0) return;
  if (run.maps.empty() || run.maps.back().id != update.map_id) {
    run.maps.emplace_back();
    run.maps.back().id = update.map_id;
  }
  PublishedMap& map = run.maps.back();
  for (const KeyframeView& keyframe : update.keyframes) map.keyframes[keyframe.id] = keyframe;
  for (const LandmarkView& landmark : update.landmarks) map.landmarks[landmark.id] = landmark;
  for (const std::int64_t id : update.removed_landmarks) map.landmarks.erase(id);
}

int frame_at(const CaseRun& run, std::int64_t time_us) {
  int i = 0;
  while (run.results[static_cast<std::size_t>(i)].time_us != time_us) ++i;
  return i;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Depth in the map over the true one, of the landmarks that are on a surface in their anchor's
// image.
std::vector<double> depth_ratios(const PublishedMap& map, const SimulatedWorld& world,
                                 const CaseRun& run) {
  std::map<std::int64_t, cv::Mat> depths;
  std::vector<double> ratios;
  for (const auto& [id, landmark] : map.landmarks) {
    const auto anchor = map.keyframes.find(landmark.anchor);
    const Eigen::Vector3d& x = landmark.position_in_anchor;
    if (anchor == map.keyframes.end() || x.z() <= 0) continue;
    cv::Mat& depth = depths[landmark.anchor];
    if (depth.empty()) depth = world.depth(frame_at(run, anchor->second.time_us));
    const Eigen::Vector2d p = run.camera.pixel_from_normalized(x.head<2>() / x.z());
    const cv::Point pixel(static_cast<int>(std::lround(p.x())),
                          static_cast<int>(std::lround(p.y())));
    if (!cv::Rect(0, 0, depth.cols, depth.rows).contains(pixel)) continue;
    const float truth = depth.at<float>(pixel);
    if (truth > 0) ratios.push_back(x.z() / static_cast<double>(truth));
  }
  return ratios;
}

Camera camera_of(const Case& which, const SimulatedWorld& world) {
  Camera camera = world.camera();
  camera.fx *= which.focal_factor;
  camera.fy *= which.focal_factor;
  return camera;
}

}  // namespace

CaseRun run_case(const Case& which, const SimulatedWorld& world) {
  CaseRun run;
  run.camera = camera_of(which, world);
  const Camera& camera = run.camera;
  Mapper mapper(camera, MapperOptions());
  FeatureExtractor extractor;
  for (int i = 0; i < world.num_frames(); ++i) {
    const std::int64_t time_us = world.time_us(i);
    run.truth.push_back({seconds(time_us), world.world_from_camera(i)});
    const FrameResult result =
        mapper.process(extract_frame(extractor, world.render(i), camera, {time_us, 1, i, "cam0"}));
    if (result.map_updated) take_update(mapper.map_update(), run);
    if (result.state == TrackingState::kTracking)
      run.maps.back().poses.push_back({seconds(time_us), result.map_from_camera});
    run.results.push_back(result);
    run.keyframes.push_back(mapper.statistics().keyframes);
    run.landmarks.push_back(mapper.statistics().landmarks);
  }
  return run;
}

MapError map_error(const PublishedMap& map, const SimulatedWorld& world, const CaseRun& run) {
  MapError result;
  result.poses = static_cast<int>(map.poses.size());
  if (!map.poses.empty()) {
    const auto before = [](const TumPose& pose, double time) { return pose.time_s < time; };
    const auto first = std::lower_bound(run.truth.begin(), run.truth.end(),
                                        map.poses.front().time_s - 1e-4, before);
    const auto end =
        std::lower_bound(first, run.truth.end(), map.poses.back().time_s + 1e-4, before);
    const TrajectoryError error =
        trajectory_error(std::span(first, end), map.poses, TrajectoryErrorOptions{1e-3, 0});
    result.path = error.path_m;
    if (error.aligned) {
      result.rmse = error.rmse_m;
      result.scale = error.truth_from_estimate.scale;
    }
  }
  const std::vector<double> ratios = depth_ratios(map, world, run);
  const double unit = median(ratios);
  std::vector<double> errors;
  for (const double ratio : ratios) errors.push_back(std::abs(ratio / unit - 1));
  result.points = static_cast<int>(errors.size());
  result.depth_error = median(errors);
  if (!errors.empty())
    result.wrong_points = static_cast<double>(std::count_if(errors.begin(), errors.end(),
                                                            [](double e) { return e > 0.3; })) /
                          result.points;
  return result;
}

}  // namespace eifmap::test
