// The sparse extended information filter over all keyframe poses and all features: [WD10] IV.
//
// Every measurement keeps its frozen, whitened Jacobian H and the residual r that is left of it at
// the mean: I = sum H'H, and the mean moves by delta with I delta = sum H'r. That is [WD10] (7)
// with the constant parts moved to the other side, and what `Relinearize::kOnce` does. Otherwise
// the right-hand side is of the Jacobians and residuals at the mean, which ends at the
// least-squares mean, and H is frozen again where a measurement has moved (linearization.h).
//
// I is never formed whole: features meet poses only, so they are eliminated exactly (Schur
// complement) and only the poses' matrix is factored, of that only what a change reaches. Sights
// of what has not moved are not looked at.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "filter/filter_state.h"
#include "filter/landmark_set.h"
#include "filter/linearization.h"
#include "filter/pose_index.h"
#include "filter/reduced_system.h"
#include "filter/sight_correlation.h"
#include "filter/sparse_cholesky.h"
#include "geometry/projection.h"
#include "geometry/rigid3.h"
#include "options.h"
#include "reason.h"

namespace eifmap {

// A 6-vector's derivative to the error (w, dc) of one pose, or of earth_from_map.
struct PoseSensitivity {
  int pose = 0;
  PoseBlock derivative = PoseBlock::Zero();
};

struct FilterUpdate {
  struct Dropped {
    int landmark = 0, pose = 0;
  };
  Reason reason = Reason::kNone;  // or kFilterFailed: the mean is as before
  int iterations = 0;             // steps of all poses
  std::size_t relinearized = 0;   // sights, summed over the steps
  std::vector<Dropped> dropped;   // sightings that do not fit and were taken out
  int dropped_edges = 0;
  // Of the newest pose's sights of landmarks that are seen well, before what does not fit was taken
  // out: the median of their whitened errors over what it is where sigmas are right, whatever a
  // minority of wrong ones says.
  double newest_spread = 0;
  int num_newest = 0;  // of how many; 0: no spread
};

// Of InformationFilter::iterate_whole().
struct WholeIteration {
  bool ok = false;          // else the matrix cannot be factored, and the mean is as before
  double squared_step = 0;  // sigmas, as the gradient asks for
};

// By one innovation: the map's variance with which it is of median size, and with which only one in
// ten is larger.
struct VarianceAskedFor {
  double by_median = 1, by_tenth = 1;
};

// What a filter holds besides poses, landmarks and what was measured.
struct FilterBooks {
  bool has_gauge = false, is_metric = false, is_placed = false, has_level = false;
  ScaleGauge gauge;
  Rigid3 earth_from_map;
  Eigen::Vector3d held_up = Eigen::Vector3d::Zero();
  double absolute_weight = 1, map_variance = 1, edge_variance = 1;
  std::vector<VarianceAskedFor> variances_asked_for;
};

class InformationFilter {
 public:
  // `radians_per_pixel` turns the options' pixels into normalized image coordinates.
  InformationFilter(const FilterOptions& options, double radians_per_pixel);

  // Handles are indices, in the order of adding, and stay valid. The first pose is the gauge: it
  // never moves.
  int add_pose(const Rigid3& world_from_camera);
  // `covariance`: given the poses, until the next update. To be measured before that: one without
  // measurements counts as removed.
  int add_landmark(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance);
  void add_measurement(int landmark, int pose, const Eigen::Vector2d& x, double sigma);
  void remove_measurement(int landmark, int pose);
  void remove_landmark(int landmark);  // and its distances
  // Multiplies the sigmas of all sights and edges so far. The next update looks at everything.
  void scale_sigmas(double factor);
  // Takes out a pose with all that was measured from it; any but the first two, which are the
  // gauge. Its handle stays valid and is not used again: the pose has no covariance, and is
  // wherever carry() says.
  void remove_pose(int pose);
  bool is_removed(int pose) const { return removed_[pose] != 0; }
  void carry(int removed_pose, const Rigid3& world_from_camera);
  // False when the covariance cannot be inverted.
  bool add_edge(int i, int j, const RelativePose& pose);
  // As another filter has it.
  void add_edge(int i, int j, const RelativePoseMeasurement& measurement);

  // Absolute measurements, absolute_measurements.cpp. Before the first, the map's unit becomes the
  // metre by this: all lengths times `factor`, after which no gauge holds the scale but what is
  // added below, before the next update. What the sights say does not change. Throws
  // std::invalid_argument before the first update, for a factor that is not positive, and when it
  // is metric already.
  void make_metric(double metres_per_unit);
  bool is_metric() const { return is_metric_; }
  // About where absolute positions are; another unknown from now on. Again: begins anew from there.
  // Of a metric map alone, else std::invalid_argument.
  void set_earth_from_map(const Rigid3& earth_from_map);
  bool has_earth() const { return is_placed_; }
  // About how an earth whose z axis is up is turned: for measurements of which way is down, before
  // or without any position, of a map with or without scale. Until set_earth_from_map() what no
  // such measurement tells, the turn about up and where earth's origin is, are by definition. Of a
  // map that has two poses and neither earth nor level, else std::invalid_argument.
  void set_level(const Eigen::Quaterniond& earth_from_map);
  // Up in the map (unit) as gravity has it, where earth is placed but its turn about a line of
  // positions is not told: the best fit of both. Else std::invalid_argument.
  void stand_earth_upright(const Eigen::Vector3d& up_in_map);
  bool has_level() const { return system_.blocks().has_earth(); }  // with an earth, too
  // Up in the map as set_level() found it, while that holds; else zero.
  const Eigen::Vector3d& held_up() const { return system_.held_up(); }
  // With has_level().
  const Rigid3& earth_from_map() const { return earth_from_map_; }
  // Refused, with a reason: not finite, a covariance that is not positive definite, too many points
  // or coinciding ones, a pose that no update has had yet, a position without earth_from_map, down
  // without a level, a landmark that is not seen; and, `gated`, what contradicts the map by its
  // innovation. Of known poses, and but for down of a metric map alone, else std::invalid_argument.
  // `again`: its innovation has been counted.
  Reason add_absolute(const AbsoluteObservation& observation, bool gated = true,
                      bool again = false);
  const std::vector<FilterAbsolute>& absolutes() const { return absolutes_; }
  // What the map's covariances must be multiplied by for the innovations of absolute measurements
  // to be as large as they should: 1 while they are right, more where what disturbs the images (a
  // calibration that is off) is in no keypoint's sigma. Where most of the latest contradict what it
  // is, by their median, which wrong measurements do not move while most are right; once found it
  // stays.
  double map_variance() const { return map_variance_; }
  // What all covariances are multiplied by: that, and what a track's errors ask for.
  double variance() const { return correlation_.variance_factor() * map_variance_; }
  // What their information is multiplied by. The filter takes the errors of a track's sights for
  // independent and multiplies all covariances by variance() afterwards; absolute measurements are
  // as good as they say, and so count that much more before.
  double absolute_weight() const { return absolute_weight_; }

  // Moves the mean to where it belongs; then drops what does not fit. What stays further than a
  // thousandth of its sigma from the exact least-squares mean goes on with the next update.
  FilterUpdate update();

  // Puts poses (all that are in use; by handle, removed ones are passed over) and landmarks where
  // they are said to be, all by themselves: a start for the next update, which linearizes
  // everything there, and no information. The first pose must stay, as the gauge;
  // std::invalid_argument otherwise, and when a pose or a landmark is missing or not finite, and
  // before the first update.
  void move(const std::vector<Rigid3>& poses,
            const std::vector<std::pair<int, Eigen::Vector3d>>& positions);

  // One Gauss-Newton step of everything: all measurements are linearized, all blocks summed and
  // factored anew, all poses and landmarks moved. What an update does only where it must.
  WholeIteration iterate_whole();

  // For a map that is kept in a file: what is not in the rest of this interface; and all of it
  // again, once poses, landmarks, sights and edges are there as they were. The mean stays where it
  // is, everything is linearized there, and covariances are known. False, where the books or the
  // measurements are not a filter's, or the matrix cannot be factored: then this one is of no use.
  FilterBooks books() const;
  bool restore(const FilterBooks& books, const std::vector<AbsoluteObservation>& absolutes);

  // Whether an absolute measurement of that kind is of this pose; of any.
  bool has_absolute(int pose, AbsoluteObservation::Kind kind) const;
  bool has_absolute(AbsoluteObservation::Kind kind) const;
  int num_distances(int landmark) const;  // measured ones to others
  int num_poses() const { return static_cast<int>(poses_.size()); }
  int num_landmarks() const { return static_cast<int>(landmarks_.size()); }  // removed ones too
  // What the edges' covariances are multiplied by, as of the last update: 1 while they are right.
  double edge_variance() const { return edge_variance_; }
  int num_edges() const { return static_cast<int>(edges_.size()); }
  std::size_t num_measurements() const;
  const Rigid3& pose(int i) const { return poses_[i]; }
  const Eigen::Vector3d& position(int landmark) const { return landmarks_[landmark].position; }
  const FilterLandmark& landmark(int i) const { return landmarks_[i]; }
  const FilterLandmarks& landmarks() const { return landmarks_; }
  const FilterEdges& edges() const { return edges_; }
  const SightCorrelation& correlation() const { return correlation_; }
  const PoseBlocks& blocks() const { return system_.blocks(); }

  // Norm of the whitened reprojection error at the mean (the number of sigmas); infinite behind the
  // camera.
  double error(int landmark, const PointMeasurement& measurement) const;

  // Marginal covariances, in the gauge: the first pose is where it is by definition, and the first
  // baseline keeps its length along its first direction until the map is metric. Errors of a
  // track's sights are not independent, and that is allowed for (sight_correlation.h). As of the
  // last successful update; false before it, or for what was added after it.
  //
  // Of one pose (w, dc).
  bool pose_covariance(int pose, PoseBlock& covariance) const;
  // Of a landmark's position (world): V^-1 + V^-1 W' Sigma_pp W V^-1 over the poses that see it.
  bool landmark_covariance(int landmark, Eigen::Matrix3d& covariance) const;
  // Of a sum of linear functions of poses.
  bool propagate(const std::vector<PoseSensitivity>& sensitivities, PoseBlock& covariance) const;
  // How the poses' mean would move (w, dc; by block, one after the other) for these right-hand
  // sides of the reduced system, one a column.
  bool steps_of(const Eigen::MatrixXd& right_sides, Eigen::MatrixXd& steps) const;
  // Of several poses and landmarks at once, which is faster than one by one. `poses`, `landmarks`:
  // handles without repetition.
  bool covariances(const std::vector<int>& poses, const std::vector<int>& landmarks,
                   std::vector<PoseBlock>& of_poses,
                   std::vector<Eigen::Matrix3d>& of_landmarks) const;

 private:
  // Of the mean, as the gradient asks for.
  struct Step {
    Eigen::VectorXd delta;  // by block
    double squared = 0;     // sigmas
    bool of_all = false;    // or of the latest poses alone
  };

  template <class Predicate>
  void remove_measurements(int landmark, Predicate predicate);
  template <class Predicate>
  void remove_absolutes(Predicate predicate);
  void check_ends(int i, int j) const;
  void touch(int landmark);
  void touch(int landmark, const Eigen::Vector3d& position_before);
  void judge_edges();
  void judge_absolutes();
  bool has_baseline(const AbsoluteObservation& observation) const;
  Reason check(const AbsoluteObservation& observation) const;
  void linearize_moved(FilterAbsolute& absolute);
  // Rows at the mean. Of a distance of landmarks `of_landmarks` is the variance that they add
  // (landmark_distance.h), of others 0.
  AbsoluteRows rows_of(const AbsoluteObservation& observation, double& of_landmarks) const;
  bool knows_landmarks(const AbsoluteObservation& observation) const;
  void judge_map_variance(const VarianceAskedFor& newest);
  bool passes_gate(const FilterAbsolute& absolute, bool again);
  void find_earth_again(const AbsoluteObservation& newest);
  struct PositionPairs {
    Eigen::Matrix3Xd in_earth, in_map;
    double squared_error(const Rigid3& earth_from_map) const;
  };
  PositionPairs position_pairs(const AbsoluteObservation* newest) const;
  bool settle(FilterUpdate& update);
  bool next_step(bool ask_latest, Step& step);
  std::size_t linearize_moved();
  void linearize_all_anew();
  bool is_restorable(const FilterBooks& books) const;
  void judge_landmark(int landmark);
  bool sparse_covariances(const std::vector<int>& poses, const std::vector<int>& landmarks,
                          std::vector<PoseBlock>& of_poses,
                          std::vector<Eigen::Matrix3d>& of_landmarks) const;
  bool factor_for_all();
  void apply(const Eigen::VectorXd& delta_poses);
  bool move_alone(FilterLandmark& landmark, double still) const;
  Holding holding() const;
  void set_pose(int pose, const Rigid3& world_from_camera);
  void undo();
  bool knows(int pose) const {
    return cholesky_.has_factor() && (pose == 0 || system_.blocks().of(pose) >= 0) &&
           system_.blocks().of(pose) < system_.matrix().size() &&
           (pose == kEarthFromMap || removed_[pose] == 0);
  }
  void drop_sights(const std::vector<int>& landmarks, double gate, FilterUpdate& update);
  template <class Predicate>
  bool must_stay(int landmark, Predicate is_off) const;
  bool drop_edges(FilterUpdate& update);
  void judge_newest(FilterUpdate& update) const;

  FilterOptions options_;
  double radians_per_pixel_;
  std::vector<Rigid3> poses_;
  std::vector<Projector> projectors_;  // of the poses
  std::vector<std::uint8_t> removed_;  // by pose
  int num_removed_ = 0;                // poses
  FilterLandmarks landmarks_;
  FilterEdges edges_;
  std::vector<FilterAbsolute> absolutes_;
  Rigid3 earth_from_map_, earth_before_;  // with has_level(); before the update
  bool is_metric_ = false, is_placed_ = false;
  double absolute_weight_ = 1, map_variance_ = 1;
  std::vector<VarianceAskedFor> variances_asked_for_;  // the latest
  PoseIndex index_;
  // Landmarks with another measurement, place or residual than when they were last linearized and
  // summed; and since the last update that succeeded. No other sights need be looked at.
  LandmarkSet touched_, touched_in_update_;
  // The mean of before an update, while there is one, or the last has failed.
  std::vector<Rigid3> poses_before_;
  std::vector<std::pair<int, Eigen::Vector3d>> positions_before_;  // of what was touched in it
  double edge_variance_ = 1;  // what the edges' covariances are multiplied by
  ScaleGauge gauge_;          // of the first two poses, as they were at the first update
  bool has_gauge_ = false;
  ReducedSystem system_;     // over all poses but the first, and earth_from_map
  SparseCholesky cholesky_;  // of the last update's matrix; as new where that failed
  bool shrunk_ = false;      // the matrix has lost blocks since
  CorrelationSums correlation_sums_;
  SightCorrelation correlation_;  // as of the last update
};

}  // namespace eifmap
