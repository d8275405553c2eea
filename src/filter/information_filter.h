// The sparse extended information filter over all keyframe poses and all features: [WD10] IV.
//
// Every measurement keeps its frozen, whitened Jacobian H and the residual r that is left of it at
// the mean: I = sum H'H, and the mean moves by delta with I delta = sum H'r. That is [WD10] (7)
// with the constant parts moved to the other side. A measurement is linearized again when its
// prediction moved by more than a threshold; with the threshold at infinity this is (7) to the
// letter, at zero it is incremental bundle adjustment.
//
// I is never formed whole: features meet poses only, so they are eliminated exactly (Schur
// complement) and only the poses' matrix is factored, of that only what a change reaches. Sights
// of what has not moved are not looked at.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "filter/filter_state.h"
#include "filter/reduced_system.h"
#include "filter/sight_correlation.h"
#include "filter/sparse_cholesky.h"
#include "geometry/projection.h"
#include "geometry/rigid3.h"
#include "options.h"
#include "reason.h"

namespace eifmap {

// A 6-vector's derivative to the error (w, dc) of one pose.
struct PoseSensitivity {
  int pose = 0;
  PoseBlock derivative = PoseBlock::Zero();
};

struct FilterUpdate {
  struct Dropped {
    int landmark = 0, pose = 0;
  };
  Reason reason = Reason::kNone;  // or kFilterFailed: the mean is as before
  int iterations = 0;
  std::size_t relinearized = 0;  // measurements, summed over the iterations
  std::vector<Dropped> dropped;  // sightings that do not fit and were taken out
  int dropped_edges = 0;
};

class InformationFilter {
 public:
  // `radians_per_pixel` turns the options' pixels into normalized image coordinates.
  InformationFilter(const FilterOptions& options, double radians_per_pixel);

  // Handles are indices, in the order of adding, and stay valid. The first pose is the gauge: it
  // never moves.
  int add_pose(const Rigid3& world_from_camera);
  // `covariance`: given the poses, until the next update.
  int add_landmark(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance);
  void add_measurement(int landmark, int pose, const Eigen::Vector2d& x, double sigma);
  void remove_measurement(int landmark, int pose);
  void remove_landmark(int landmark);
  // False when the covariance cannot be inverted.
  bool add_edge(int i, int j, const RelativePose& pose);

  // Solves, moves the mean, linearizes again what moved, until nothing does; then drops what does
  // not fit.
  FilterUpdate update();

  int num_poses() const { return static_cast<int>(poses_.size()); }
  int num_landmarks() const { return static_cast<int>(landmarks_.size()); }  // removed ones too
  // What the edges' covariances are multiplied by, as of the last update: 1 while they are right.
  double edge_variance() const { return edge_variance_; }
  int num_edges() const { return static_cast<int>(edges_.size()); }
  std::size_t num_measurements() const;
  const Rigid3& pose(int i) const { return poses_[i]; }
  const Eigen::Vector3d& position(int landmark) const { return landmarks_[landmark].position; }
  const FilterLandmark& landmark(int i) const { return landmarks_[i]; }
  const std::vector<FilterEdge>& edges() const { return edges_; }
  const SightCorrelation& correlation() const { return correlation_; }

  // Norm of the whitened reprojection error at the mean (the number of sigmas); infinite behind the
  // camera.
  double error(int landmark, const PointMeasurement& measurement) const;

  // Marginal covariances, in the gauge: the first pose is where it is by definition, and the first
  // baseline keeps its length along its first direction. Errors of a track's sights are not
  // independent, and that is allowed for (sight_correlation.h). As of the last successful update;
  // false before it, or for what was added after it.
  //
  // Of one pose (w, dc).
  bool pose_covariance(int pose, PoseBlock& covariance) const;
  // Of a landmark's position (world): V^-1 + V^-1 W' Sigma_pp W V^-1 over the poses that see it.
  bool landmark_covariance(int landmark, Eigen::Matrix3d& covariance) const;
  // Of a sum of linear functions of poses.
  bool propagate(const std::vector<PoseSensitivity>& sensitivities, PoseBlock& covariance) const;
  // Of several poses and landmarks at once, which is faster than one by one. `poses`, `landmarks`:
  // handles without repetition.
  bool covariances(const std::vector<int>& poses, const std::vector<int>& landmarks,
                   std::vector<PoseBlock>& of_poses,
                   std::vector<Eigen::Matrix3d>& of_landmarks) const;

 private:
  // How far a sight may move before it is linearized again.
  struct Holding {
    double within = 0;    // normalized image coordinates
    double of_depth = 0;  // share of its depth
  };

  template <class Predicate>
  void remove_measurements(int landmark, Predicate predicate);
  void touch(int landmark);
  void touch_all();
  std::size_t linearize_moved();
  bool linearize_anew(PointMeasurement& m, const Projector& projector,
                      const Eigen::Vector3d& position, const Holding& holds) const;
  bool solve(Eigen::VectorXd& delta_poses);
  void apply(const Eigen::VectorXd& delta_poses);
  void judge_edges();
  void linearize_edge(FilterEdge& edge) const;
  bool settle(FilterUpdate& update);
  void undo(const std::vector<Rigid3>& poses, const std::vector<Eigen::Vector3d>& positions);
  bool knows(int pose) const {
    return cholesky_.has_factor() && pose >= 0 && pose <= system_.matrix().size();
  }
  void drop_sights(const std::vector<int>& landmarks, double gate, FilterUpdate& update);
  bool drop_edges(FilterUpdate& update);

  FilterOptions options_;
  double radians_per_pixel_;
  std::vector<Rigid3> poses_;
  std::vector<FilterLandmark> landmarks_;
  std::vector<FilterEdge> edges_;
  PoseIndex index_;
  // Landmarks with another measurement, place or residual than when they were last linearized and
  // summed; and since the last update that succeeded. No other sights need be looked at.
  LandmarkSet touched_, touched_in_update_;
  double edge_variance_ = 1;  // what the edges' covariances are multiplied by
  ScaleGauge gauge_;          // of the first two poses, as they were at the first update
  bool has_gauge_ = false;
  ReducedSystem system_;     // over all poses but the first
  SparseCholesky cholesky_;  // of the last update's matrix; as new where that failed
  CorrelationSums correlation_sums_;
  SightCorrelation correlation_;  // as of the last update
};

}  // namespace eifmap
