#include "options.h"

namespace eifmap {
namespace {

std::string say(const char* field, double value, const char* wanted) {
  return std::string(field) + " is " + std::to_string(value) + ", wanted " + wanted;
}

std::string start_problem(const StartOptions& o) {
  if (o.min_features < 8) return say("start.min_features", o.min_features, "8 or more");
  if (o.min_matches < 8) return say("start.min_matches", o.min_matches, "8 or more");
  if (!(o.max_sigma_direction_deg > 0))
    return say("start.max_sigma_direction_deg", o.max_sigma_direction_deg, "above 0");
  if (o.min_points < 8) return say("start.min_points", o.min_points, "8 or more");
  if (!(o.max_relative_depth > 0))
    return say("start.max_relative_depth", o.max_relative_depth, "above 0");
  if (o.max_frames < 2) return say("start.max_frames", o.max_frames, "2 or more");
  if (o.triangulated_keyframes < 0)
    return say("start.triangulated_keyframes", o.triangulated_keyframes, "0 or more");
  return "";
}

std::string keyframe_problem(const KeyframeOptions& o) {
  if (!(o.min_tracked_ratio >= 0 && o.min_tracked_ratio <= 1))
    return say("keyframe.min_tracked_ratio", o.min_tracked_ratio, "0 to 1");
  if (!(o.max_baseline_ratio > 0))
    return say("keyframe.max_baseline_ratio", o.max_baseline_ratio, "above 0");
  if (!(o.near_share > 0)) return say("keyframe.near_share", o.near_share, "above 0");
  if (o.few_tracked < 0) return say("keyframe.few_tracked", o.few_tracked, "0 or more");
  if (o.min_inliers < 6) return say("keyframe.min_inliers", o.min_inliers, "6 or more");
  if (!(o.redundant_share > 0))
    return say("keyframe.redundant_share", o.redundant_share, "above 0");
  if (o.enough_views < 2) return say("keyframe.enough_views", o.enough_views, "2 or more");
  if (o.keep_newest < 2) return say("keyframe.keep_newest", o.keep_newest, "2 or more");
  return "";
}

std::string landmark_problem(const LandmarkOptions& o) {
  if (o.neighbours < 1) return say("landmark.neighbours", o.neighbours, "1 or more");
  if (!(o.min_parallax_deg >= 0))
    return say("landmark.min_parallax_deg", o.min_parallax_deg, "0 or more");
  if (!(o.max_relative_depth > 0))
    return say("landmark.max_relative_depth", o.max_relative_depth, "above 0");
  if (!(o.max_error > 0)) return say("landmark.max_error", o.max_error, "above 0");
  if (o.min_views < 2) return say("landmark.min_views", o.min_views, "2 or more");
  if (o.min_views_if_few < 2)
    return say("landmark.min_views_if_few", o.min_views_if_few, "2 or more");
  if (o.few_tracked < 0) return say("landmark.few_tracked", o.few_tracked, "0 or more");
  if (!(o.search_radius_px > 0))
    return say("landmark.search_radius_px", o.search_radius_px, "above 0");
  if (!(o.min_baseline_sigma >= 0))
    return say("landmark.min_baseline_sigma", o.min_baseline_sigma, "0 or more");
  return "";
}

std::string edge_problem(const EdgeOptions& o) {
  if (!(o.max_sigma_direction_deg > 0))
    return say("edge.max_sigma_direction_deg", o.max_sigma_direction_deg, "above 0");
  if (o.min_measurements < 8) return say("edge.min_measurements", o.min_measurements, "8 or more");
  if (!(o.max_spent_ratio > 0 && o.max_spent_ratio <= 1))
    return say("edge.max_spent_ratio", o.max_spent_ratio, "above 0, at most 1");
  if (o.neighbours < 0) return say("edge.neighbours", o.neighbours, "0 or more");
  return "";
}

std::string filter_problem(const FilterOptions& o) {
  if (!(o.relinearize_px >= 0)) return say("filter.relinearize_px", o.relinearize_px, "0 or more");
  if (!(o.relinearize_depth >= 0))
    return say("filter.relinearize_depth", o.relinearize_depth, "0 or more");
  if (o.max_iterations < 1) return say("filter.max_iterations", o.max_iterations, "1 or more");
  if (!(o.huber_sigma > 0)) return say("filter.huber_sigma", o.huber_sigma, "above 0");
  if (!(o.gate_sigma > 1)) return say("filter.gate_sigma", o.gate_sigma, "above 1");
  return "";
}

std::string measurement_problem(const MeasurementOptions& o) {
  if (!(o.max_dt_s >= 0)) return say("measurement.max_dt_s", o.max_dt_s, "0 or more");
  if (!(o.max_scale_sigma > 0 && o.max_scale_sigma <= 0.2))
    return say("measurement.max_scale_sigma", o.max_scale_sigma, "above 0, at most 0.2");
  if (o.min_positions < 4) return say("measurement.min_positions", o.min_positions, "4 or more");
  if (o.max_waiting < 1) return say("measurement.max_waiting", o.max_waiting, "1 or more");
  if (!(o.focal_sigma >= 0 && o.focal_sigma < 0.5))
    return say("measurement.focal_sigma", o.focal_sigma, "0 or more, below 0.5");
  if (!(o.centre_sigma_px >= 0 && o.centre_sigma_px < 1000))
    return say("measurement.centre_sigma_px", o.centre_sigma_px, "0 or more, below 1000");
  if (!(o.radial_sigma >= 0 && o.radial_sigma < 1))
    return say("measurement.radial_sigma", o.radial_sigma, "0 or more, below 1");
  return "";
}

std::string lost_problem(const LostOptions& o) {
  if (o.min_inliers < 6) return say("lost.min_inliers", o.min_inliers, "6 or more");
  if (o.places < 0) return say("lost.places", o.places, "0 or more");
  if (!(o.new_map_after_s >= 0)) return say("lost.new_map_after_s", o.new_map_after_s, "0 or more");
  if (o.max_kept_maps < 0) return say("lost.max_kept_maps", o.max_kept_maps, "0 or more");
  if (!(o.min_share_seen >= 0 && o.min_share_seen <= 1))
    return say("lost.min_share_seen", o.min_share_seen, "0 to 1");
  return "";
}

std::string loop_problem(const LoopOptions& o) {
  if (o.max_candidates < 1) return say("loop.max_candidates", o.max_candidates, "1 or more");
  if (o.min_gap < 1) return say("loop.min_gap", o.min_gap, "1 or more");
  if (o.min_matches < 6) return say("loop.min_matches", o.min_matches, "6 or more");
  if (o.consecutive < 1) return say("loop.consecutive", o.consecutive, "1 or more");
  if (o.min_inliers < 15) return say("loop.min_inliers", o.min_inliers, "15 or more");
  if (o.min_cells < 1 || o.min_cells > 16) return say("loop.min_cells", o.min_cells, "1 to 16");
  if (o.min_scale_pairs < 3) return say("loop.min_scale_pairs", o.min_scale_pairs, "3 or more");
  if (!(o.max_scale_sigma > 0)) return say("loop.max_scale_sigma", o.max_scale_sigma, "above 0");
  if (!(o.drift_factor >= 1)) return say("loop.drift_factor", o.drift_factor, "1 or more");
  if (!(o.drift_share >= 0 && o.drift_share < 1))
    return say("loop.drift_share", o.drift_share, "0 or more, below 1");
  if (o.max_compared < 1) return say("loop.max_compared", o.max_compared, "1 or more");
  return "";
}

std::string bound_problem(const BoundOptions& o) {
  if (o.max_keyframes != 0 && o.max_keyframes < 20)
    return say("bound.max_keyframes", o.max_keyframes, "0 or at least 20");
  if (o.max_landmarks != 0 && o.max_landmarks < 500)
    return say("bound.max_landmarks", o.max_landmarks, "0 or at least 500");
  return "";
}

}  // namespace

MapperOptions MapperOptions::paper() {
  MapperOptions paper;
  paper.relative_pose.covariance = RelativePoseCovariance::kUnscented;
  paper.scale_fit.method = ScaleFitMethod::kPlain;
  paper.start.triangulated_keyframes = 3;
  paper.max_sigma_growth = 1;
  paper.keyframe.redundant_share = 2;
  paper.tracking.refine = false;
  paper.tracking.older_reference = false;
  paper.tracking.fall_back = false;
  paper.tracking.search_sigma = 0;
  paper.tracking.second_search = false;
  paper.landmark.promote_omega_p = false;
  paper.landmark.min_views = 2;
  paper.filter.relinearize = Relinearize::kOnce;
  paper.filter.judge_edges = false;
  return paper;
}

std::string MapperOptions::problem() const {
  if (!(sigma_factor > 0)) return say("sigma_factor", sigma_factor, "above 0");
  if (!(max_sigma_growth >= 1)) return say("max_sigma_growth", max_sigma_growth, "1 or more");
  if (tracking.near_keyframes < 0)
    return say("tracking.near_keyframes", tracking.near_keyframes, "0 or more");
  if (!(tracking.search_sigma >= 0))
    return say("tracking.search_sigma", tracking.search_sigma, "0 or more");
  if (!(tracking.min_inlier_ratio >= 0 && tracking.min_inlier_ratio <= 1))
    return say("tracking.min_inlier_ratio", tracking.min_inlier_ratio, "0 to 1");
  for (const std::string& problem :
       {match.problem(), relative_pose.problem(), scale_fit.problem(), absolute_pose.problem(),
        start_problem(start), keyframe_problem(keyframe), landmark_problem(landmark),
        edge_problem(edge), filter_problem(filter), measurement_problem(measurement),
        lost_problem(lost), loop_problem(loop), bound_problem(bound)})
    if (!problem.empty()) return problem;
  return "";
}

}  // namespace eifmap
