#include "consistency/map_judgement.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "sequence/consistency.h"

namespace eifmap::test {
namespace {

double nees_of_point(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  return error.dot(covariance.llt().solve(error));
}

}  // namespace

void LandmarkPoints::add(const FrameSource& source, const MapUpdate& update) {
  for (const KeyframeView& keyframe : update.keyframes) times_[keyframe.id] = keyframe.time_us;
  for (const ObservationView& o : update.observations)
    if (const auto point = source.point_at(times_.at(o.keyframe), o.u, o.v))
      ++counts_[o.landmark][*point];
}

std::optional<Eigen::Vector3d> LandmarkPoints::operator()(const FrameSource& source,
                                                          std::int64_t landmark) const {
  const auto found = counts_.find(landmark);
  if (found == counts_.end()) return std::nullopt;
  const auto most =
      std::max_element(found->second.begin(), found->second.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return source.point(most->first);
}

std::vector<double> judge_landmarks(const Mapper& mapper, const TruePoint& truth) {
  std::map<std::int64_t, Rigid3> poses;
  for (const KeyframeView& k : mapper.keyframes()) poses[k.id] = k.map_from_camera;
  std::vector<double> all;
  for (const LandmarkView& l : mapper.landmarks())
    if (const auto point = truth(l.id); point && l.covariance.allFinite())
      all.push_back(
          nees_of_point(*point - poses.at(l.anchor) * l.position_in_anchor, l.covariance));
  return all;
}

std::vector<double> judge_landmarks(const EarthView& view, const TruePoint& truth) {
  std::vector<double> all;
  for (const EarthView::Landmark& l : view.landmarks)
    if (const auto point = truth(l.id); point && l.covariance.allFinite())
      all.push_back(nees_of_point(*point - l.position, l.covariance));
  return all;
}

std::vector<double> judge_relative(const Mapper& mapper, const TruePose& truth, std::size_t apart) {
  const std::vector<KeyframeView> keyframes = mapper.keyframes();
  std::vector<double> all;
  for (std::size_t k = apart; k < keyframes.size(); ++k) {
    const KeyframeView &a = keyframes[k - apart], &b = keyframes[k];
    const auto true_a = truth(a.time_us), true_b = truth(b.time_us);
    const auto relative = mapper.relative_pose(a.id, b.id);
    if (k < 2 || !true_a || !true_b || !relative) continue;
    all.push_back(
        nees(pose_error(relative->a_from_b, true_a->inverse() * *true_b), relative->covariance));
  }
  return all;
}

std::vector<double> judge_keyframes(const EarthView& view, const TruePose& truth) {
  std::vector<double> all;
  for (const EarthView::Keyframe& k : view.keyframes)
    if (const auto pose = truth(k.time_us); pose && k.covariance.allFinite())
      all.push_back(nees(pose_error(k.earth_from_camera, *pose), k.covariance));
  return all;
}

std::optional<double> log_scale_error(const std::vector<KeyframeView>& keyframes,
                                      const TruePose& truth, std::size_t count) {
  const std::size_t first = count == 0 || keyframes.size() < count ? 0 : keyframes.size() - count;
  const auto n = static_cast<double>(keyframes.size() - first);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t k = first; k < keyframes.size(); ++k)
    mean += keyframes[k].map_from_camera.translation / n;
  double squared = 0, along = 0;
  for (std::size_t k = first; k < keyframes.size(); ++k) {
    const auto pose = truth(keyframes[k].time_us);
    if (!pose) return std::nullopt;
    const Eigen::Vector3d& centre = keyframes[k].map_from_camera.translation;
    squared += (centre - mean).squaredNorm();
    along += (centre - mean).dot(pose->translation - centre);
  }
  return squared > 0 ? std::optional(along / squared) : std::nullopt;
}

}  // namespace eifmap::test
