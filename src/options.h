// Every setting of the mapping path: nested by step, a default and a why each. problem() of the
// whole names the first field that is wrong.
#pragma once

#include <string>

#include "features/matcher.h"
#include "motion/absolute_pose.h"
#include "motion/relative_pose.h"
#include "motion/scale_fit.h"

namespace eifmap {

// The start of a map: [WD10] IV, first paragraph.
struct StartOptions {
  // An anchor with fewer features than this is not worth waiting for.
  int min_features = 60;
  int min_matches = 40;  // with the anchor
  // The direction of the first baseline must be this certain: it is the gauge of the whole map.
  double max_sigma_direction_deg = 1.5;
  int min_points = 50;              // whose sigma_Z / Z is below the next
  double max_relative_depth = 0.2;  // sigma_Z / Z of a point that counts
  // Frames kept to be posed backwards when the map starts, which must not take long.
  int max_frames = 100;
  // [WD10] IV makes the map's beginning from a set of images, each posed by plain triangulation:
  // so many keyframes after the first two.
  int triangulated_keyframes = 0;
};

// Where the search for a new frame's pose starts, given its 5-DOF relative pose.
enum class PoseStart {
  kScaleFit,       // the length of the step from the map: [WD10] III
  kSameSpeed,      // the length from the last step: [WD10] Algorithm 1, step 3, and no further
  kTriangulation,  // the length from the map's depths to those triangulated: what [WD10]'s abstract
                   // compares with
  kPnp,            // no relative pose: P3P on the map
};

struct TrackingOptions {
  PoseStart start = PoseStart::kScaleFit;
  // Too near the reference for a relative pose: fit against an older keyframe, before the map alone
  // has to do.
  bool older_reference = false;
  // Where the map does not confirm that: the other ways along the line, and at last PnP.
  bool fall_back = true;
  // Refine all 6 DOF on the local map before the filter gets the pose. [WD10] does not.
  bool refine = true;
  // Landmarks are looked for within so many sigmas of the innovation (the pose's, the landmark's
  // and the keypoint's error together), where the pose's error is known; 0: anywhere within
  // landmark.search_radius_px.
  double search_sigma = 8;
  // And once more from where the pose of the first search sees them. [WD10] does not.
  bool second_search = true;
  // That takes in what so many keyframes see that are near but share little with the reference: on
  // a way back the landmarks of the way there. Off: where the ends of a lap are joined by it, the
  // last poses are a little too sure (NEES 7.6 of 6 over 30 laps).
  int near_keyframes = 0;
  // Of the landmarks found near their predicted places (or, in PnP, matched), the share that must
  // agree with the pose. Chance alone makes about one in ten agree with any pose.
  double min_inlier_ratio = 0.3;
};

struct KeyframeOptions {
  double min_tracked_ratio = 0.6;    // fewer of the reference's landmarks tracked: a new keyframe
  double max_baseline_ratio = 0.05;  // baseline / median depth above this: a new keyframe
  // That of the reference, or of a keyframe before the newest that sees this share of the tracked
  // landmarks, where tracking.near_keyframes is not 0. Above 1: of the reference.
  double near_share = 0.5;
  // With fewer tracked landmarks than this the map needs new ones soon: half the baseline will do.
  int few_tracked = 120;
  int min_inliers = 25;  // below this a keyframe would be built on sand
  // Where a new keyframe comes, one goes of whose landmarks this share is seen from enough_views
  // others. Above 1: none goes.
  double redundant_share = 0.9;
  int enough_views = 5;  // with 3 a car's keyframes went that it never came back to
  int keep_newest = 10;  // keyframes, redundant or not: tracking and new landmarks rest on them
};

struct LandmarkOptions {
  int neighbours = 4;                // previous keyframes matched; one alone cost 1.32 m for .77
  double min_parallax_deg = 1.0;     // of the widest pair of views
  double max_relative_depth = 0.25;  // sigma_Z / Z to enter the filter
  double max_error = 3.0;            // whitened reprojection error in each view
  int min_views = 3;                 // two and a third that agrees
  // The same where the new keyframe tracked fewer than few_tracked: a feature may be out of view
  // before it has been seen a third time. A third view is what finds wrong matches: with two
  // wherever fewer than 120 were tracked, NEES in a recorded room was 12 instead of 6.
  int min_views_if_few = 2;
  int few_tracked = 60;         // landmarks
  double search_radius_px = 8;  // guided search: never further from the predicted pixel
  // No triangulation over a baseline of less than so many sigmas of the new keyframe's place: its
  // own error would make the depths.
  double min_baseline_sigma = 10;
  // A keyframe that no edge is admitted for gives its Omega_p to the map.
  bool promote_omega_p = false;
};

// Relative-pose edges: [WD10] II and (6), (7).
struct EdgeOptions {
  bool enabled = true;                   // false: the map's landmarks alone hold the poses
  double max_sigma_direction_deg = 1.5;  // of an edge that is admitted
  int min_measurements = 50;             // that no edge has used
  // Of the matches of a pair, the share that one edge may spend: the rest is left for the next
  // edge, since a measurement enters one edge only.
  double max_spent_ratio = 0.5;
  int neighbours = 6;  // keyframes tried where the reference is too near for an edge
};

// When a measurement's Jacobian is taken at the mean.
enum class Relinearize {
  kOnce,       // when it enters, and never again: [WD10] (7) to the letter
  kThreshold,  // again when its prediction, its depth or its camera moved by more than a threshold
  kAlways,     // in every iteration: incremental bundle adjustment
};

struct FilterOptions {
  Relinearize relinearize = Relinearize::kThreshold;
  // Both of a map of up to 50 keyframes; of one with n, 50 / n of it. They decide how fast an
  // update converges and how exact the covariances are, not, robust weights aside, where the map
  // ends.
  double relinearize_px = 0.1;
  double relinearize_depth = 1e-3;  // share of its depth
  int max_iterations = 5;           // of all poses, per update
  // Edges' covariances grow as far as the map shows that they are too small. [WD10] trusts them.
  bool judge_edges = true;
  double huber_sigma = 2.0;  // whitened residual from which a sighting counts less
  double gate_sigma = 3.5;   // whitened residual above which a sighting is dropped as an outlier
};

// What a map may grow to; 0: no bound. Past it the least informative goes.
struct BoundOptions {
  // 200 to 370 come in a minute of unbroken new ground (recordings in a room and of a car), so that
  // this is an hour of it at least. The filter of 5,000 takes 1.4 GiB, and 57 ms a keyframe
  // (src/filter/size.md).
  int max_keyframes = 20000;
  int max_landmarks = 1000000;  // 50 for each keyframe
};

// Absolute measurements: positions, distances.
struct MeasurementOptions {
  // A measurement belongs to an image this close in time; between two images it is interpolated.
  // Half the time between images at 10 Hz.
  double max_dt_s = 0.05;
  // Standard deviation of the scale's logarithm with which a map becomes metric: at 5 % nothing
  // that is linear in the scale is far off.
  double max_scale_sigma = 0.05;
  int min_positions = 4;    // for that; a similarity transform takes 7 numbers of their 12
  int max_waiting = 10000;  // of their images, and of the scale: hours at 1 Hz
  // What the calibration may be off by, as far as that makes the scale drift along a way, which no
  // residual shows: standard deviation of the focal length, relative. This and the next two are
  // what calibration tools usually reach.
  double focal_sigma = 0.002;
  double centre_sigma_px = 1.0;  // the same of the principal point, each axis
  double radial_sigma = 0.003;   // the same of the first radial coefficient, k1
};

struct LostOptions {
  int min_inliers = 30;  // to believe a relocalization, or one keyframe's word for a pose
  // Keyframes asked first where a lost camera is: those that look most like its image.
  int places = 5;
  double new_map_after_s = 2.0;  // lost this long: a new map may start
  // Maps that were left are kept: the camera is looked for in them, and one that turns out to be of
  // the same place becomes one with the map in use. That with the fewest keyframes goes first. 0:
  // none is.
  int max_kept_maps = 8;
  // Of what two maps should show of each other at a place, the share that is seen before they
  // become one.
  double min_share_seen = 0.3;
};

// Loop closure: a place that is seen again.
struct LoopOptions {
  bool enabled = false;    // until it has proven itself
  int max_candidates = 4;  // keyframes matched with each new one: about a millisecond each
  int min_gap = 20;        // keyframes between the two passes of a place
  int min_matches = 20;    // landmarks of an old keyframe matched; by chance it is about 10
  int consecutive = 3;     // keyframes in a row that must point to the same place
  int min_inliers = 40;    // map features of the old place that agree with one pose
  int min_cells = 5;       // of 16 parts of the image that they are in
  // Features with a depth on both sides. They give the scale, which is what drifts most, by the
  // median of the depths' ratios.
  int min_scale_pairs = 15;
  double max_scale_sigma = 0.05;  // standard deviation of the scale's logarithm that they give
  // What the map may be off by: so many times what its covariances say, for what disturbs the
  // images beyond their sigmas.
  double drift_factor = 3;
  double drift_share = 0.01;  // and so much of the way between the passes, as a calibration may be
  int max_compared = 100;  // keyframes elsewhere, the most alike, that must not explain the image
};

// The Laplacian sign whose features make the map (Omega_m); the other's (Omega_p) give relative
// poses.
enum class MapSignChoice {
  kMinus,  // bright blobs on dark
  kPlus,   // dark on bright
  kBoth,   // all features make the map, and there are no edges
  kMerit,  // that of which more is still seen when a map starts: longer tracks
};

struct MapperOptions {
  MapSignChoice map_sign = MapSignChoice::kMinus;
  // Tracks in maps that were made before, and makes nothing of what it sees.
  bool localize_only = false;
  // A keypoint's own sigma is that of its place in one image. Seen from elsewhere a blob looks
  // different: measured on real pairs, matches that fit the epipolar geometry scatter by twice
  // that.
  double sigma_factor = 2.0;
  // Where the map shows that it is more, up to so many times as much (map/sight_noise.h); 1: never.
  double max_sigma_growth = 3.0;
  MatchOptions match;
  RelativePoseOptions relative_pose;
  ScaleFitOptions scale_fit;
  AbsolutePoseOptions absolute_pose;
  StartOptions start;
  TrackingOptions tracking;
  KeyframeOptions keyframe;
  LandmarkOptions landmark;
  EdgeOptions edge;
  FilterOptions filter;
  MeasurementOptions measurement;
  LostOptions lost;
  LoopOptions loop;
  BoundOptions bound;

  std::string problem() const;  // "" or which field is wrong and why

  // [WD10] to the letter, where the letter is known.
  static MapperOptions paper();
};

}  // namespace eifmap
