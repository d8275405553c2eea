#include "sequence/trajectory_error.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <variant>

namespace eifmap {
namespace {

double path_length(const Eigen::Matrix3Xd& points) {
  double length = 0;
  for (Eigen::Index k = 1; k < points.cols(); ++k)
    length += (points.col(k) - points.col(k - 1)).norm();
  return length;
}

// What an estimated pose is compared with.
struct Pair {
  int estimate = 0, truth = 0;    // truth: the nearest in time
  Eigen::Vector3d true_position;  // at the estimate's time
};

std::optional<Pair> match_time(std::span<const TumPose> truth, double time, double max_dt) {
  const auto later = std::lower_bound(truth.begin(), truth.end(), time,
                                      [](const TumPose& p, double t) { return p.time_s < t; });
  const auto j = static_cast<int>(later - truth.begin()), n = static_cast<int>(truth.size());
  const auto distance = [&](int i) { return std::abs(truth[i].time_s - time); };
  if (n == 0) return std::nullopt;
  int nearest = std::clamp(j, 0, n - 1);
  if (j > 0 && (j == n || distance(j - 1) <= distance(j))) nearest = j - 1;
  if (distance(nearest) > max_dt) return std::nullopt;
  Pair pair{0, nearest, truth[nearest].world_from_camera.translation};
  if (distance(nearest) > 1e-6 && j > 0 && j < n) {
    const TumPose &before = truth[j - 1], &after = truth[j];
    const double span = after.time_s - before.time_s, w = (time - before.time_s) / span;
    if (span <= 2 * max_dt + 1e-9)
      pair.true_position =
          (1 - w) * before.world_from_camera.translation + w * after.world_from_camera.translation;
  }
  return pair;
}

std::vector<Pair> match_times(std::span<const TumPose> truth, std::span<const TumPose> estimate,
                              double max_dt) {
  std::vector<Pair> pairs;
  for (std::size_t k = 0; k < estimate.size(); ++k) {
    if (auto pair = match_time(truth, estimate[k].time_s, max_dt)) {
      pair->estimate = static_cast<int>(k);
      pairs.push_back(*pair);
    }
  }
  return pairs;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

void position_errors(const Eigen::Matrix3Xd& truth, const Eigen::Matrix3Xd& estimate,
                     TrajectoryError& error) {
  error.truth_from_estimate = fit_similarity(truth, estimate);
  std::vector<double> distances;
  double sum = 0;
  for (Eigen::Index k = 0; k < truth.cols(); ++k) {
    distances.push_back((truth.col(k) - error.truth_from_estimate * estimate.col(k)).norm());
    sum += distances.back() * distances.back();
  }
  error.rmse_m = std::sqrt(sum / static_cast<double>(truth.cols()));
  error.max_m = *std::max_element(distances.begin(), distances.end());
  error.median_m = median(std::move(distances));
  error.covered_path_m = path_length(truth);
}

// A constant rotation between what the two sides call the camera's frame is taken out first.
double rotation_rmse_deg(std::span<const TumPose> truth, std::span<const TumPose> estimate,
                         std::span<const Pair> pairs, const Eigen::Matrix3d& truth_from_estimate) {
  std::vector<Eigen::Matrix3d> a, b;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Pair& pair : pairs) {
    a.push_back(truth_from_estimate * estimate[pair.estimate].world_from_camera.matrix());
    b.push_back(truth[pair.truth].world_from_camera.matrix());
    sum += a.back().transpose() * b.back();
  }
  const Eigen::Matrix3d offset = nearest_rotation(sum);
  double square = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const double cosine = (((a[k] * offset).transpose() * b[k]).trace() - 1) / 2;
    const double angle = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
    square += angle * angle;
  }
  return std::sqrt(square / static_cast<double>(a.size()));
}

using Figure = std::pair<const char*, std::variant<double, int>>;

std::vector<Figure> figures(const TrajectoryError& e) {
  std::vector<Figure> list{{"path_m", e.path_m}, {"gt_poses", e.true_poses}};
  if (e.frames > 0) list.emplace_back("frames", e.frames);
  list.emplace_back("poses", e.poses);
  if (e.coverage) list.emplace_back("coverage", *e.coverage);
  list.emplace_back("matched", e.matched);
  if (!e.aligned) return list;
  list.insert(list.end(),
              {{"ate_rmse_m", e.rmse_m},
               {"ate_median_m", e.median_m},
               {"ate_max_m", e.max_m},
               {"covered_path_m", e.covered_path_m},
               {"ate_pct", e.percent_of_path()},
               {"ate_pct_of_covered", 100 * e.rmse_m / std::max(e.covered_path_m, 1e-9)},
               {"scale", e.truth_from_estimate.scale},
               {"rot_rmse_deg", e.rotation_rmse_deg}});
  return list;
}

}  // namespace

TrajectoryError trajectory_error(std::span<const TumPose> truth, std::span<const TumPose> estimate,
                                 const TrajectoryErrorOptions& options) {
  TrajectoryError error;
  Eigen::Matrix3Xd true_path(3, truth.size());
  for (std::size_t k = 0; k < truth.size(); ++k)
    true_path.col(k) = truth[k].world_from_camera.translation;
  error.path_m = path_length(true_path);
  error.true_poses = static_cast<int>(truth.size());
  error.poses = static_cast<int>(estimate.size());
  if (options.num_frames > 0) {
    int distinct = 0;
    for (std::size_t k = 0; k < estimate.size(); ++k)
      distinct += k == 0 || estimate[k].time_s != estimate[k - 1].time_s;
    error.frames = options.num_frames;
    error.coverage = static_cast<double>(distinct) / options.num_frames;
  }
  const auto pairs = match_times(truth, estimate, options.max_dt_s);
  error.matched = static_cast<int>(pairs.size());
  if (pairs.size() < 3) return error;
  Eigen::Matrix3Xd a(3, pairs.size()), b(3, pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    a.col(k) = pairs[k].true_position;
    b.col(k) = estimate[pairs[k].estimate].world_from_camera.translation;
  }
  if (!((b.rowwise().maxCoeff() - b.rowwise().minCoeff()).maxCoeff() > 0)) return error;
  error.aligned = true;
  position_errors(a, b, error);
  error.rotation_rmse_deg =
      rotation_rmse_deg(truth, estimate, pairs, error.truth_from_estimate.rotation);
  return error;
}

std::string json_text(const TrajectoryError& error) {
  nlohmann::ordered_json json;
  for (const auto& [name, value] : figures(error))
    std::visit([&json, name = name](auto number) { json[name] = number; }, value);
  return json.dump();
}

std::string plain_text(const TrajectoryError& error) {
  std::string text;
  for (const auto& [name, value] : figures(error)) {
    char line[96];
    if (const int* count = std::get_if<int>(&value))
      std::snprintf(line, sizeof(line), "%-20s %d\n", name, *count);
    else
      std::snprintf(line, sizeof(line), "%-20s %.4f\n", name, std::get<double>(value));
    text += line;
  }
  return text;
}

}  // namespace eifmap
