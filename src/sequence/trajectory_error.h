// How far an estimated trajectory is from the truth: absolute trajectory error after the best
// similarity transform (S. Umeyama, PAMI 1991).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "geometry/similarity.h"
#include "sequence/tum.h"

namespace eifmap {

struct TrajectoryErrorOptions {
  // An estimated pose counts when a true one is this close in time; where two true ones enclose it
  // and are at most twice this apart, the true position is interpolated.
  double max_dt_s = 0.05;
  int num_frames = 0;  // images there were, for the coverage; 0: unknown
};

struct TrajectoryError {
  double path_m = 0;  // of the whole truth
  int true_poses = 0, poses = 0, matched = 0;
  int frames = 0;                  // 0: unknown
  std::optional<double> coverage;  // distinct times of the estimate / frames

  // The rest is there when at least 3 poses matched and the estimate moved.
  bool aligned = false;
  double rmse_m = 0, median_m = 0, max_m = 0;  // of the distances after alignment
  double covered_path_m = 0;                   // of the truth at the matched times
  // Of the angles left after the best constant rotation between the two camera frames.
  double rotation_rmse_deg = 0;
  Similarity truth_from_estimate;  // its scale is the figure 'scale'

  double percent_of_path() const { return 100 * rmse_m / path_m; }
};

// Both sorted by time, as read_tum gives them.
TrajectoryError trajectory_error(std::span<const TumPose> truth, std::span<const TumPose> estimate,
                                 const TrajectoryErrorOptions& options);

// The figures with the names that other tools print, in order; a JSON object's text, or 'name
// value' lines with 4 decimals.
std::string json_text(const TrajectoryError& error);
std::string plain_text(const TrajectoryError& error);

}  // namespace eifmap
