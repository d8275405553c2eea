// Every setting's name, once: what reads, prints and tests the configuration visits these.
#pragma once

#include "server/config.h"

namespace eifmap {

// visit_fields(object, visitor) calls visitor(name, field) for each field of a struct, in order.
// `Options` is a struct below or a const one.
template <class Options, class Of>
concept OptionsOf = std::same_as<std::remove_const_t<Options>, Of>;

template <OptionsOf<Camera> O>
void visit_fields(O& o, auto&& visit) {
  visit("width", o.width);
  visit("height", o.height);
  visit("model", o.model);
  visit("fx", o.fx);
  visit("fy", o.fy);
  visit("cx", o.cx);
  visit("cy", o.cy);
  visit("distortion", o.distortion);
}

template <OptionsOf<SurfOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("octaves", o.octaves);
  visit("sampling_step", o.sampling_step);
  visit("min_response", o.min_response);
}

template <OptionsOf<SiftOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("octave_layers", o.octave_layers);
  visit("contrast_threshold", o.contrast_threshold);
  visit("edge_threshold", o.edge_threshold);
}

template <OptionsOf<RollOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("dead_band_deg", o.dead_band_deg);
}

template <OptionsOf<FeatureOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("extractor", o.extractor);
  visit("max_features", o.max_features);
  visit("surf", o.surf);
  visit("sift", o.sift);
  visit("roll", o.roll);
}

template <OptionsOf<MatchOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("max_ratio", o.max_ratio);
  visit("max_distance", o.max_distance);
  visit("mutual", o.mutual);
}

template <OptionsOf<RelativePoseOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("min_matches", o.min_matches);
  visit("min_median_parallax_px", o.min_median_parallax_px);
  visit("max_rotation_inlier_ratio", o.max_rotation_inlier_ratio);
  visit("ransac_threshold_px", o.ransac_threshold_px);
  visit("ransac_confidence", o.ransac_confidence);
  visit("ransac_iterations", o.ransac_iterations);
  visit("seed", o.seed);
  visit("min_inlier_ratio", o.min_inlier_ratio);
  visit("covariance", o.covariance);
  visit("check_planar", o.check_planar);
}

template <OptionsOf<ScaleFitOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("method", o.method);
  visit("min_inliers", o.min_inliers);
  visit("min_inlier_ratio", o.min_inlier_ratio);
  visit("max_relative_sigma", o.max_relative_sigma);
  visit("max_runner_up", o.max_runner_up);
  visit("bisquare", o.bisquare);
  visit("max_spread", o.max_spread);
}

template <OptionsOf<AbsolutePoseOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("min_inliers", o.min_inliers);
  visit("gate_sigma", o.gate_sigma);
  visit("max_iterations", o.max_iterations);
  visit("bisquare", o.bisquare);
  visit("ransac_threshold_px", o.ransac_threshold_px);
  visit("ransac_confidence", o.ransac_confidence);
  visit("ransac_iterations", o.ransac_iterations);
  visit("seed", o.seed);
}

template <OptionsOf<StartOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("min_features", o.min_features);
  visit("min_matches", o.min_matches);
  visit("max_sigma_direction_deg", o.max_sigma_direction_deg);
  visit("min_points", o.min_points);
  visit("max_relative_depth", o.max_relative_depth);
  visit("max_frames", o.max_frames);
  visit("triangulated_keyframes", o.triangulated_keyframes);
}

template <OptionsOf<TrackingOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("start", o.start);
  visit("older_reference", o.older_reference);
  visit("fall_back", o.fall_back);
  visit("search_sigma", o.search_sigma);
  visit("second_search", o.second_search);
  visit("near_keyframes", o.near_keyframes);
  visit("refine", o.refine);
  visit("min_inlier_ratio", o.min_inlier_ratio);
}

template <OptionsOf<KeyframeOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("min_tracked_ratio", o.min_tracked_ratio);
  visit("max_baseline_ratio", o.max_baseline_ratio);
  visit("near_share", o.near_share);
  visit("few_tracked", o.few_tracked);
  visit("min_inliers", o.min_inliers);
  visit("redundant_share", o.redundant_share);
  visit("enough_views", o.enough_views);
  visit("keep_newest", o.keep_newest);
}

template <OptionsOf<LandmarkOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("neighbours", o.neighbours);
  visit("min_parallax_deg", o.min_parallax_deg);
  visit("max_relative_depth", o.max_relative_depth);
  visit("max_error", o.max_error);
  visit("min_views", o.min_views);
  visit("min_views_if_few", o.min_views_if_few);
  visit("few_tracked", o.few_tracked);
  visit("search_radius_px", o.search_radius_px);
  visit("min_baseline_sigma", o.min_baseline_sigma);
  visit("promote_omega_p", o.promote_omega_p);
}

template <OptionsOf<EdgeOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("enabled", o.enabled);
  visit("max_sigma_direction_deg", o.max_sigma_direction_deg);
  visit("min_measurements", o.min_measurements);
  visit("max_spent_ratio", o.max_spent_ratio);
  visit("neighbours", o.neighbours);
}

template <OptionsOf<FilterOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("relinearize", o.relinearize);
  visit("relinearize_px", o.relinearize_px);
  visit("relinearize_depth", o.relinearize_depth);
  visit("max_iterations", o.max_iterations);
  visit("judge_edges", o.judge_edges);
  visit("huber_sigma", o.huber_sigma);
  visit("gate_sigma", o.gate_sigma);
}

template <OptionsOf<MeasurementOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("max_dt_s", o.max_dt_s);
  visit("max_scale_sigma", o.max_scale_sigma);
  visit("min_positions", o.min_positions);
  visit("max_waiting", o.max_waiting);
  visit("focal_sigma", o.focal_sigma);
  visit("centre_sigma_px", o.centre_sigma_px);
  visit("radial_sigma", o.radial_sigma);
}

template <OptionsOf<LostOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("min_inliers", o.min_inliers);
  visit("places", o.places);
  visit("new_map_after_s", o.new_map_after_s);
  visit("max_kept_maps", o.max_kept_maps);
  visit("min_share_seen", o.min_share_seen);
}

template <OptionsOf<LoopOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("enabled", o.enabled);
  visit("max_candidates", o.max_candidates);
  visit("min_gap", o.min_gap);
  visit("min_matches", o.min_matches);
  visit("consecutive", o.consecutive);
  visit("min_inliers", o.min_inliers);
  visit("min_cells", o.min_cells);
  visit("min_scale_pairs", o.min_scale_pairs);
  visit("max_scale_sigma", o.max_scale_sigma);
  visit("drift_factor", o.drift_factor);
  visit("drift_share", o.drift_share);
  visit("max_compared", o.max_compared);
}

template <OptionsOf<BoundOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("max_keyframes", o.max_keyframes);
  visit("max_landmarks", o.max_landmarks);
}

template <OptionsOf<MapperOptions> O>
void visit_fields(O& o, auto&& visit) {
  visit("map_sign", o.map_sign);
  visit("localize_only", o.localize_only);
  visit("sigma_factor", o.sigma_factor);
  visit("max_sigma_growth", o.max_sigma_growth);
  visit("match", o.match);
  visit("relative_pose", o.relative_pose);
  visit("scale_fit", o.scale_fit);
  visit("absolute_pose", o.absolute_pose);
  visit("start", o.start);
  visit("tracking", o.tracking);
  visit("keyframe", o.keyframe);
  visit("landmark", o.landmark);
  visit("edge", o.edge);
  visit("filter", o.filter);
  visit("measurement", o.measurement);
  visit("lost", o.lost);
  visit("loop", o.loop);
  visit("bound", o.bound);
}

template <OptionsOf<ServerConfig> O>
void visit_fields(O& o, auto&& visit) {
  visit("lcm_url", o.lcm_url);
  visit("camera", o.camera);
  visit("max_cameras", o.max_cameras);
  visit("image_channel", o.image_channel);
  visit("gray16_bits", o.gray16_bits);
  visit("input", o.input);
  visit("max_queued_mib", o.max_queued_mib);
  visit("max_part_bytes", o.max_part_bytes);
  visit("map_bytes_per_s", o.map_bytes_per_s);
  visit("status_period_s", o.status_period_s);
  visit("secret_file", o.secret_file);
  visit("calibration", o.calibration);
  visit("hfov_deg", o.hfov_deg);
  visit("handover_frames", o.handover_frames);
  visit("maps_folder", o.maps_folder);
  visit("metrics_port", o.metrics_port);
  visit("metrics_address", o.metrics_address);
  visit("features", o.features);
  visit("mapper", o.mapper);
}

}  // namespace eifmap
