#include "filter/information_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "geometry/projection.h"
#include "geometry/robust.h"

namespace eifmap {
namespace {

// Of an edge (5 degrees of freedom): about 1 in 7 is beyond it by chance.
constexpr double kEdgeLimit = 3.0;

// Huber's weight: full to k sigmas, then falling as k / error. The weight is part of the
// measurement's noise, Q, and is frozen with its Jacobian.
double robust_weight(double error, double k) {
  return error <= k ? 1 : k / error;
}

// Chi-square of 5 degrees of freedom, 1 in 100,000: an edge beyond it contradicts the map.
constexpr double kEdgeGate = 30.9;

// What edges claim of themselves, against what the map, whose features have many more sights, says
// of them: 1 where they are right, more where whatever disturbs the images (a calibration that is
// off, a rolling shutter) is in no keypoint's sigma. From the median, which a few wrong edges do
// not move; as if kTrusted edges more had been right.
double variance_of_edges(const std::vector<FilterEdge>& edges) {
  constexpr double kMedianOfChi5 = 4.351, kTrusted = 10, kLargest = 16;
  std::vector<double> errors;
  for (const FilterEdge& edge : edges)
    if (edge.linearized) errors.push_back(edge.squared_error);
  const auto n = static_cast<double>(errors.size());
  const double factor = (kTrusted + n * take_median(errors) / kMedianOfChi5) / (kTrusted + n);
  return std::clamp(factor, 1.0, kLargest);
}

}  // namespace

InformationFilter::InformationFilter(const FilterOptions& options, double radians_per_pixel)
    : options_(options), radians_per_pixel_(radians_per_pixel) {}

int InformationFilter::add_pose(const Rigid3& world_from_camera) {
  poses_.push_back(world_from_camera);
  return num_poses() - 1;
}

int InformationFilter::add_landmark(const Eigen::Vector3d& position,
                                    const Eigen::Matrix3d& covariance) {
  FilterLandmark landmark;
  landmark.position = position;
  landmark.covariance = covariance;
  landmarks_.push_back(std::move(landmark));
  return static_cast<int>(landmarks_.size()) - 1;
}

void InformationFilter::add_measurement(int landmark, int pose, const Eigen::Vector2d& x,
                                        double sigma) {
  if (pose < 0 || pose >= num_poses() || !(sigma > 0))
    throw std::invalid_argument("InformationFilter: no such pose, or sigma not positive");
  PointMeasurement measurement;
  measurement.pose = pose;
  measurement.x = x;
  measurement.sigma = sigma;
  landmarks_.at(landmark).measurements.push_back(measurement);
  landmarks_[landmark].changed = true;
}

template <class Predicate>
void InformationFilter::remove_measurements(FilterLandmark& landmark, Predicate predicate) {
  if (std::none_of(landmark.measurements.begin(), landmark.measurements.end(), predicate)) return;
  system_.before_removal(landmark);
  std::erase_if(landmark.measurements, predicate);
  landmark.changed = true;
}

void InformationFilter::remove_measurement(int landmark, int pose) {
  remove_measurements(landmarks_.at(landmark),
                      [pose](const PointMeasurement& m) { return m.pose == pose; });
}

void InformationFilter::remove_landmark(int landmark) {
  remove_measurements(landmarks_.at(landmark), [](const PointMeasurement&) { return true; });
}

bool InformationFilter::add_edge(int i, int j, const RelativePose& pose) {
  if (i == j || std::min(i, j) < 0 || std::max(i, j) >= num_poses())
    throw std::invalid_argument("InformationFilter: an edge needs two known poses");
  FilterEdge edge;
  edge.i = i;
  edge.j = j;
  if (!make_measurement(pose, edge.measurement)) return false;
  edges_.push_back(edge);
  return true;
}

std::size_t InformationFilter::num_measurements() const {
  std::size_t n = 0;
  for (const FilterLandmark& landmark : landmarks_) n += landmark.measurements.size();
  return n;
}

double InformationFilter::error(int landmark, const PointMeasurement& measurement) const {
  Eigen::Vector2d predicted;
  if (!project(poses_[measurement.pose], landmarks_[landmark].position, predicted))
    return std::numeric_limits<double>::infinity();
  return (measurement.x - predicted).norm() / measurement.sigma;
}

// Linearizes what is new and what moved; returns how many.
std::size_t InformationFilter::linearize_moved() {
  const bool once = options_.relinearize == Relinearize::kOnce;
  const double threshold = options_.relinearize == Relinearize::kThreshold
                               ? options_.relinearize_px * radians_per_pixel_
                               : 0;
  std::vector<Projector> projectors;
  projectors.reserve(poses_.size());
  for (const Rigid3& pose : poses_) projectors.emplace_back(pose);
  std::size_t count = 0;
  for (FilterLandmark& landmark : landmarks_) {
    for (PointMeasurement& m : landmark.measurements) {
      if (once && m.linearized) continue;
      Eigen::Vector2d predicted;
      if (!projectors[m.pose](landmark.position, predicted)) {
        // Behind the camera: without weight until the outlier test takes it out.
        landmark.changed = landmark.changed || m.linearized;
        m.d_pose.setZero(), m.d_landmark.setZero(), m.residual.setZero();
        m.linearized = false;
        continue;
      }
      if (m.linearized && (predicted - m.predicted).norm() <= threshold) continue;
      projectors[m.pose](landmark.position, predicted, &m.d_pose, &m.d_landmark);
      const Eigen::Vector2d residual = (m.x - predicted) / m.sigma;
      const double root = std::sqrt(robust_weight(residual.norm(), options_.huber_sigma));
      m.d_pose *= root / m.sigma;
      m.d_landmark *= root / m.sigma;
      m.residual = root * residual;
      m.predicted = predicted;
      m.linearized = true;
      landmark.changed = true;
      ++count;
    }
  }
  for (FilterEdge& edge : edges_) linearize_edge(edge);
  return count;
}

// Edges are few, and cheap: at the mean every time, unless nothing is ever linearized again.
void InformationFilter::linearize_edge(FilterEdge& edge) const {
  RelativePoseLinearization at_mean;
  const bool defined = linearize(edge.measurement, poses_[edge.i], poses_[edge.j], at_mean);
  edge.squared_error =
      defined ? at_mean.residual.squaredNorm() : std::numeric_limits<double>::infinity();
  if (edge.linearized && options_.relinearize == Relinearize::kOnce) return;
  edge.linearization = at_mean;
  edge.linearized = defined;
  if (!defined) return;
  const double error = std::sqrt(edge.squared_error / edge_variance_);
  const double root = std::sqrt(robust_weight(error, kEdgeLimit) / edge_variance_);
  edge.linearization.residual *= root;
  edge.linearization.d_i *= root;
  edge.linearization.d_j *= root;
}

bool InformationFilter::solve(bool same_pattern, Eigen::VectorXd& delta_poses) {
  system_.sum(num_poses(), landmarks_, edges_, same_pattern);
  system_.add_scale_gauge(gauge_, poses_[1].translation - poses_[0].translation);
  if (!cholesky_.factor(system_.matrix(), same_pattern)) return false;
  delta_poses = cholesky_.solve(system_.right_side());
  return delta_poses.allFinite();
}

// mu <- mu + delta, and the part of each residual that this explains is taken off it. A landmark's
// step is V^-1 (b - W' delta): what its poses' step leaves of the residuals.
void InformationFilter::apply(const Eigen::VectorXd& delta_poses) {
  for (FilterLandmark& landmark : landmarks_) {
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (PointMeasurement& m : landmark.measurements) {
      if (m.pose > 0) m.residual.noalias() -= m.d_pose * delta_poses.segment<6>(6 * (m.pose - 1));
      b.noalias() += m.d_landmark.transpose() * m.residual;
    }
    const Eigen::Vector3d step = landmark.v_inverse * b;
    landmark.position += step;
    for (PointMeasurement& m : landmark.measurements) m.residual.noalias() -= m.d_landmark * step;
  }
  for (FilterEdge& edge : edges_) {
    RelativePoseLinearization& at = edge.linearization;
    if (edge.i > 0) at.residual.noalias() -= at.d_i * delta_poses.segment<6>(6 * (edge.i - 1));
    if (edge.j > 0) at.residual.noalias() -= at.d_j * delta_poses.segment<6>(6 * (edge.j - 1));
  }
  for (int p = 1; p < num_poses(); ++p) {
    const auto delta = delta_poses.segment<6>(6 * (p - 1));
    poses_[p] = retract(poses_[p], delta.head<3>(), delta.tail<3>());
  }
}

void InformationFilter::drop_sights(double gate, FilterUpdate& update) {
  for (int l = 0; l < num_landmarks(); ++l) {
    const auto is_off = [&](const PointMeasurement& m) { return !(error(l, m) <= gate); };
    for (const PointMeasurement& m : landmarks_[l].measurements)
      if (is_off(m)) update.dropped.push_back({l, m.pose});
    remove_measurements(landmarks_[l], is_off);
  }
}

bool InformationFilter::drop_edges(FilterUpdate& update) {
  const auto dropped =
      std::erase_if(edges_, [](const FilterEdge& edge) { return edge.squared_error > kEdgeGate; });
  update.dropped_edges += static_cast<int>(dropped);
  return dropped > 0;
}

// Solves and linearizes again until nothing moves. False, with the mean as it was, when the matrix
// cannot be factored.
bool InformationFilter::settle(FilterUpdate& update) {
  const std::vector<Rigid3> poses_before = poses_;
  std::vector<Eigen::Vector3d> positions_before;
  for (const FilterLandmark& landmark : landmarks_) positions_before.push_back(landmark.position);
  for (int i = 0; i < options_.max_iterations; ++i) {
    const std::size_t moved = linearize_moved();
    if (i > 0 && moved == 0) break;
    update.relinearized += moved;
    Eigen::VectorXd delta;
    if (!solve(i > 0, delta)) {
      cholesky_ = SparseCholesky();
      poses_ = poses_before;
      for (std::size_t l = 0; l < landmarks_.size(); ++l) {
        landmarks_[l].position = positions_before[l];
        for (PointMeasurement& m : landmarks_[l].measurements) m.linearized = false;
      }
      return false;
    }
    apply(delta);
    ++update.iterations;
  }
  linearize_moved();  // so that what is judged next, and the next update, start from the mean
  return true;
}

FilterUpdate InformationFilter::update() {
  FilterUpdate result;
  if (num_poses() < 2) return result;
  if (!has_gauge_) {
    const Eigen::Vector3d baseline = poses_[1].translation - poses_[0].translation;
    gauge_ = {baseline.normalized(), baseline.norm()};
    has_gauge_ = true;
  }
  if (options_.judge_edges) edge_variance_ = variance_of_edges(edges_);
  bool settled = settle(result);
  if (!settled) {
    // What is far off at the mean of before may be what spoils the matrix: once more without it.
    constexpr double kFarOff = 3;
    drop_sights(kFarOff * options_.gate_sigma, result);
    settled = settle(result);
  }
  // A wrong edge pulls the sights off: it goes first, and they are judged without it.
  if (settled && drop_edges(result)) settled = settle(result);
  if (!settled) {
    result.reason = Reason::kFilterFailed;
    return result;
  }
  drop_sights(options_.gate_sigma, result);
  correlation_ = measure_correlation(landmarks_, poses_);
  for (FilterLandmark& landmark : landmarks_)
    if (!landmark.measurements.empty())
      landmark.covariance =
          landmark.changed ? conditional_covariance(landmark) : landmark.v_inverse;
  return result;
}

}  // namespace eifmap
