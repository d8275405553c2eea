#include "consistency/judgement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>

#include "consistency/map_judgement.h"
#include "mapper.h"
#include "sequence/measurements_file.h"
#include "support/thread_cpu.h"

namespace eifmap::test {
namespace {

double nees_of_part(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  return error.dot(covariance.llt().solve(error));
}

JudgedPose judge(std::int64_t time_us, const Rigid3& estimate, const PoseMatrix& covariance,
                 const Rigid3& truth) {
  JudgedPose judged;
  judged.time_us = time_us;
  judged.truth = truth.translation;
  judged.error = pose_error(estimate, truth);
  judged.covariance = covariance;
  judged.nees = nees(judged.error, covariance);
  judged.nees_centre = nees_of_part(judged.error.head<3>(), covariance.topLeftCorner<3, 3>());
  judged.nees_rotation = nees_of_part(judged.error.tail<3>(), covariance.bottomRightCorner<3, 3>());
  return judged;
}

class Judge {
 public:
  explicit Judge(const FrameSource& source) {
    for (int i = 0; i < source.size(); ++i)
      if (const auto pose = source.world_from_camera(i)) truth_.emplace(source.time_us(i), *pose);
  }

  // A map has begun: its first update is the whole of it.
  void begin_map(const MapUpdate& update) {
    const KeyframeView &first = update.keyframes.at(0), &second = update.keyframes.at(1);
    begun_at_ = second.time_us;
    truth_in_map_.reset();
    const auto a = truth_.find(first.time_us), b = truth_.find(second.time_us);
    if (a != truth_.end() && b != truth_.end())
      truth_in_map_.emplace(a->second, b->second, second.map_from_camera.translation);
  }

  std::optional<JudgedPose> operator()(std::int64_t time_us, const Rigid3& estimate,
                                       const PoseMatrix& covariance) const {
    const auto truth = pose(time_us);
    if (!truth || time_us <= begun_at_) return std::nullopt;
    return judge(time_us, estimate, covariance, *truth);
  }

  // In the map's frame and unit.
  std::optional<Rigid3> pose(std::int64_t time_us) const {
    const auto truth = truth_.find(time_us);
    if (!truth_in_map_ || truth == truth_.end()) return std::nullopt;
    return is_metric ? truth_in_map_->in_metres(truth->second) : (*truth_in_map_)(truth->second);
  }
  Eigen::Vector3d point(const Eigen::Vector3d& in_world) const {
    const Rigid3 there({1, 0, 0, 0}, in_world);
    return (is_metric ? truth_in_map_->in_metres(there) : (*truth_in_map_)(there)).translation;
  }
  std::optional<Rigid3> pose_in_world(std::int64_t time_us) const {
    const auto truth = truth_.find(time_us);
    return truth == truth_.end() ? std::nullopt : std::optional(truth->second);
  }

  double scale() const { return truth_in_map_ ? truth_in_map_->scale() : 0; }

  bool is_metric = false;  // the map

 private:
  std::map<std::int64_t, Rigid3> truth_;
  std::optional<TruthInMap> truth_in_map_;
  std::int64_t begun_at_ = 0;
};

std::optional<JudgedRun::ScaleError> scale_error(const Mapper& mapper, const Judge& judged,
                                                 std::size_t latest, double sigma) {
  const std::vector<KeyframeView> keyframes = mapper.keyframes();
  const auto error = log_scale_error(
      keyframes, [&](std::int64_t time) { return judged.pose(time); }, latest);
  if (!error) return std::nullopt;
  return JudgedRun::ScaleError{keyframes.back().time_us, *error, sigma};
}

void judge_map(const Mapper& mapper, const FrameSource& source, const Judge& judged,
               const LandmarkPoints& points, const Rigid3& earth_from_world, JudgedRun& run) {
  constexpr std::size_t kApart = 5;
  run.landmarks = judge_landmarks(mapper, [&](std::int64_t landmark) {
    const auto point = points(source, landmark);
    return point ? std::optional(judged.point(*point)) : std::nullopt;
  });
  run.relative = judge_relative(
      mapper, [&](std::int64_t time) { return judged.pose(time); }, kApart);
  if (judged.is_metric)
    run.scale_of_all = scale_error(mapper, judged, 0, mapper.statistics().scale.sigma);
  const auto view = mapper.in_earth();
  if (!view) return;
  run.earth_keyframes = judge_keyframes(*view, [&](std::int64_t time) {
    const auto pose = judged.pose_in_world(time);
    return pose ? std::optional(earth_from_world * *pose) : std::nullopt;
  });
  run.earth_landmarks = judge_landmarks(*view, [&](std::int64_t landmark) {
    const auto point = points(source, landmark);
    return point ? std::optional<Eigen::Vector3d>(earth_from_world * *point) : std::nullopt;
  });
}

}  // namespace

JudgedRun judge_run(const FrameSource& source, const MapperOptions& options, int every,
                    const std::vector<AbsoluteMeasurement>& measurements,
                    const Rigid3& earth_from_world) {
  constexpr std::size_t kLatest = 10;  // keyframes, as ScaleState::sigma_newest
  JudgedRun run;
  Judge judged(source);
  LandmarkPoints points;
  Mapper mapper(source.camera(), options);
  std::size_t num_measured = 0;
  for (int i = 0; i < source.size(); i += every) {
    const FeatureFrame frame = source.frame(i);
    while (num_measured < measurements.size() &&
           usable_from_us(measurements[num_measured]) <= frame.time_us)
      mapper.add_measurement(measurements[num_measured++]);
    const double begin = thread_cpu_seconds();
    const FrameResult result = mapper.process(frame);
    run.mapper_cpu_s += thread_cpu_seconds() - begin;
    ++run.frames;
    run.tracked += result.state == TrackingState::kTracking;
    judged.is_metric = result.scale.status == ScaleStatus::kFixed;
    if (result.map_updated) {
      const MapUpdate update = mapper.map_update();
      if (result.source == PoseSource::kStartSet) {
        judged.begin_map(update);
        points = {};
      }
      points.add(source, update);
      if (judged.is_metric)
        if (const auto error = scale_error(mapper, judged, kLatest, result.scale.sigma_newest))
          run.scale_newest.push_back(*error);
    }
    run.results.push_back(result);
    if (mapper.statistics().sigma_suspect && run.first_alarm == 0)
      run.first_alarm = static_cast<int>(mapper.statistics().keyframes);
    if (result.covariance_status == CovarianceStatus::kNone) continue;
    if (auto pose = judged(result.time_us, result.map_from_camera, result.covariance)) {
      pose->map_id = result.map_id;
      run.published.push_back(*pose);
    }
  }
  for (const KeyframeView& keyframe : mapper.keyframes()) {
    if (!keyframe.covariance.allFinite()) continue;
    if (auto pose = judged(keyframe.time_us, keyframe.map_from_camera, keyframe.covariance))
      run.keyframes.push_back(*pose);
  }
  judge_map(mapper, source, judged, points, earth_from_world, run);
  run.final_trajectory = mapper.final_trajectory();
  run.statistics = mapper.statistics();
  run.scale = judged.scale();
  return run;
}

std::optional<double> mean_nees(const std::vector<JudgedPose>& poses) {
  if (poses.empty()) return std::nullopt;
  double sum = 0;
  for (const JudgedPose& pose : poses) sum += pose.nees;
  return sum / static_cast<double>(poses.size());
}

double share_within_three_sigma(const std::vector<JudgedPose>& poses) {
  constexpr double kLimit = 20.062;  // chi-square of 6 degrees of freedom, 99.73 %
  const auto within = std::count_if(poses.begin(), poses.end(),
                                    [](const JudgedPose& pose) { return pose.nees <= kLimit; });
  return poses.empty() ? 0 : static_cast<double>(within) / static_cast<double>(poses.size());
}

}  // namespace eifmap::test
