#include "filter/information_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

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
  index_.add_pose();
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
  index_.add(pose, landmark);
  touch(landmark);
}

void InformationFilter::touch(int landmark) {
  touched_.insert(landmark);
  touched_in_update_.insert(landmark);
}

void InformationFilter::touch_all() {
  for (int l = 0; l < num_landmarks(); ++l) touch(l);
}

template <class Predicate>
void InformationFilter::remove_measurements(int landmark, Predicate predicate) {
  std::vector<PointMeasurement>& all = landmarks_.at(landmark).measurements;
  if (std::none_of(all.begin(), all.end(), predicate)) return;
  system_.before_removal(landmarks_[landmark]);
  for (const PointMeasurement& m : all)
    if (predicate(m)) index_.remove(m.pose, landmark);
  std::erase_if(all, predicate);
  landmarks_[landmark].changed = true;
  touch(landmark);
}

void InformationFilter::remove_measurement(int landmark, int pose) {
  remove_measurements(landmark, [pose](const PointMeasurement& m) { return m.pose == pose; });
}

void InformationFilter::remove_landmark(int landmark) {
  remove_measurements(landmark, [](const PointMeasurement&) { return true; });
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

// Linearizes the measurement at the mean where its prediction, or its depth, has moved too far from
// where it was linearized: a point that is seen almost along one ray moves far while its image
// stays, and Jacobians of another depth would bend the map. Says whether it did.
bool InformationFilter::linearize_anew(PointMeasurement& m, const Projector& projector,
                                       const Eigen::Vector3d& position,
                                       const Holding& holds) const {
  const double depth = projector.depth(position);
  Eigen::Vector2d predicted;
  if (!projector(position, predicted)) {
    // Behind the camera: without weight until the outlier test takes it out.
    m.d_pose.setZero(), m.d_landmark.setZero(), m.residual.setZero();
    return std::exchange(m.linearized, false);
  }
  if (m.linearized && (predicted - m.predicted).norm() <= holds.within &&
      std::abs(depth - m.depth) <= holds.of_depth * m.depth)
    return false;
  m.depth = depth;
  projector(position, predicted, &m.d_pose, &m.d_landmark);
  const Eigen::Vector2d residual = (m.x - predicted) / m.sigma;
  const double root = std::sqrt(robust_weight(residual.norm(), options_.huber_sigma));
  m.d_pose *= root / m.sigma;
  m.d_landmark *= root / m.sigma;
  m.residual = root * residual;
  m.predicted = predicted;
  return m.linearized = true;
}

// Linearizes what is new and what moved; returns how many.
std::size_t InformationFilter::linearize_moved() {
  const bool once = options_.relinearize == Relinearize::kOnce;
  Holding holds;
  if (options_.relinearize == Relinearize::kThreshold)
    holds = {options_.relinearize_px * radians_per_pixel_, options_.relinearize_depth};
  std::vector<Projector> projectors;
  projectors.reserve(poses_.size());
  for (const Rigid3& pose : poses_) projectors.emplace_back(pose);
  std::size_t count = 0;
  for (int l : touched_.sorted()) {
    FilterLandmark& landmark = landmarks_[l];
    for (PointMeasurement& m : landmark.measurements) {
      if (once && m.linearized) continue;
      if (!linearize_anew(m, projectors[m.pose], landmark.position, holds)) continue;
      landmark.changed = true;
      if (m.linearized) ++count;
    }
  }
  for (FilterEdge& edge : edges_) linearize_edge(edge);
  return count;
}

// Edges are linearized again when what they measure has moved by a fraction of its sigma.
void InformationFilter::linearize_edge(FilterEdge& edge) const {
  constexpr double kMoved = 0.02;  // sigmas
  if (edge.linearized && !edge.moved && !edge.changed) return;
  RelativePoseLinearization at_mean;
  const bool defined = linearize(edge.measurement, poses_[edge.i], poses_[edge.j], at_mean);
  edge.squared_error =
      defined ? at_mean.residual.squaredNorm() : std::numeric_limits<double>::infinity();
  if (edge.linearized && options_.relinearize == Relinearize::kOnce) return;
  if (edge.linearized && defined && !edge.changed &&
      options_.relinearize == Relinearize::kThreshold &&
      (at_mean.residual - edge.residual_then).norm() <= kMoved)
    return;
  edge.residual_then = at_mean.residual;
  edge.linearization = at_mean;
  edge.linearized = defined;
  edge.changed = true;
  if (!defined) return;
  const double error = std::sqrt(edge.squared_error / edge_variance_);
  const double root = std::sqrt(robust_weight(error, kEdgeLimit) / edge_variance_);
  edge.linearization.residual *= root;
  edge.linearization.d_i *= root;
  edge.linearization.d_j *= root;
}

bool InformationFilter::solve(Eigen::VectorXd& delta_poses) {
  system_.sum(index_, landmarks_, touched_.sorted(), edges_,
              poses_[1].translation - poses_[0].translation);
  touched_.clear();
  if (!cholesky_.factor(system_.matrix())) return false;
  delta_poses = cholesky_.solve(system_.right_side());
  return delta_poses.allFinite();
}

// mu <- mu + delta, and the part of each residual that this explains is taken off it. A landmark's
// step is V^-1 (b - W' delta): what its poses' step leaves of the residuals. A step far below its
// sigma is not worth what it costs to look at all that it moves: it stays in the right-hand side
// until it has grown.
void InformationFilter::apply(const Eigen::VectorXd& delta_poses) {
  // Sigmas, given all other poses: less than of the marginal. [WD10] (7) moves all.
  const double still = options_.relinearize == Relinearize::kOnce ? 0 : 1e-3;
  std::vector<std::uint8_t> moves(poses_.size(), 0);
  for (int p = 1; p < num_poses(); ++p) {
    const auto delta = delta_poses.segment<6>(6 * (p - 1));
    const double squared = delta.dot(system_.matrix().column[p - 1].block.back() * delta);
    if (squared <= still * still) continue;
    moves[p] = 1;
    for (int l : index_.landmarks(p)) touch(l);
    poses_[p] = retract(poses_[p], delta.head<3>(), delta.tail<3>());
  }
  for (int l : touched_.sorted()) {
    FilterLandmark& landmark = landmarks_[l];
    Eigen::Vector3d along = Eigen::Vector3d::Zero();
    for (PointMeasurement& m : landmark.measurements) {
      if (moves[m.pose])
        m.residual.noalias() -= m.d_pose * delta_poses.segment<6>(6 * (m.pose - 1));
      along.noalias() += m.q.transpose() * m.residual;
    }
    const Eigen::Vector3d step = landmark.r_inverse * along;
    landmark.position += step;
    for (PointMeasurement& m : landmark.measurements) m.residual.noalias() -= m.d_landmark * step;
  }
  for (FilterEdge& edge : edges_) {
    RelativePoseLinearization& at = edge.linearization;
    if (moves[edge.i]) at.residual.noalias() -= at.d_i * delta_poses.segment<6>(6 * (edge.i - 1));
    if (moves[edge.j]) at.residual.noalias() -= at.d_j * delta_poses.segment<6>(6 * (edge.j - 1));
    if (moves[edge.i] || moves[edge.j]) edge.moved = true;
  }
}

void InformationFilter::drop_sights(const std::vector<int>& landmarks, double gate,
                                    FilterUpdate& update) {
  for (int l : landmarks) {
    const auto is_off = [&](const PointMeasurement& m) { return !(error(l, m) <= gate); };
    for (const PointMeasurement& m : landmarks_[l].measurements)
      if (is_off(m)) update.dropped.push_back({l, m.pose});
    remove_measurements(l, is_off);
  }
}

bool InformationFilter::drop_edges(FilterUpdate& update) {
  const auto is_wrong = [](const FilterEdge& edge) { return edge.squared_error > kEdgeGate; };
  for (const FilterEdge& edge : edges_)
    if (is_wrong(edge)) system_.before_removal(edge);
  const auto dropped = std::erase_if(edges_, is_wrong);
  update.dropped_edges += static_cast<int>(dropped);
  return dropped > 0;
}

void InformationFilter::undo(const std::vector<Rigid3>& poses,
                             const std::vector<Eigen::Vector3d>& positions) {
  cholesky_ = SparseCholesky();
  poses_ = poses;
  for (std::size_t l = 0; l < landmarks_.size(); ++l) {
    landmarks_[l].position = positions[l];
    landmarks_[l].changed = true;
    for (PointMeasurement& m : landmarks_[l].measurements) m.linearized = false;
  }
  for (FilterEdge& edge : edges_) edge.linearized = false, edge.changed = true;
  touch_all();
}

// Solves and linearizes again until nothing moves. False, with the mean as it was, when the matrix
// cannot be factored.
bool InformationFilter::settle(FilterUpdate& update) {
  const std::vector<Rigid3> poses_before = poses_;
  std::vector<Eigen::Vector3d> positions_before;
  positions_before.reserve(landmarks_.size());
  for (const FilterLandmark& landmark : landmarks_) positions_before.push_back(landmark.position);
  for (int i = 0; i < options_.max_iterations; ++i) {
    const std::size_t moved = linearize_moved();
    if (i > 0 && moved == 0) break;
    update.relinearized += moved;
    Eigen::VectorXd delta;
    const std::vector<int> touched = touched_.sorted();
    if (!solve(delta)) {
      undo(poses_before, positions_before);
      return false;
    }
    for (int l : touched) touch(l);
    apply(delta);
    ++update.iterations;
  }
  linearize_moved();  // so that what is judged next, and the next update, start from the mean
  return true;
}

// A new estimate of it concerns every edge, so a slightly other one is not worth it.
void InformationFilter::judge_edges() {
  constexpr double kAsGood = 1.1;
  const double variance = variance_of_edges(edges_);
  if (variance < kAsGood * edge_variance_ && edge_variance_ < kAsGood * variance) return;
  edge_variance_ = variance;
  for (FilterEdge& edge : edges_) edge.changed = true;
}

FilterUpdate InformationFilter::update() {
  FilterUpdate result;
  if (num_poses() < 2) return result;
  if (!has_gauge_) {
    const Eigen::Vector3d baseline = poses_[1].translation - poses_[0].translation;
    gauge_ = {baseline.normalized(), baseline.norm()};
    has_gauge_ = true;
    system_.set_gauge(gauge_);
  }
  if (options_.judge_edges) judge_edges();
  bool settled = settle(result);
  if (!settled) {
    // What is far off at the mean of before may be what spoils the matrix: once more without it.
    constexpr double kFarOff = 3;
    drop_sights(touched_in_update_.sorted(), kFarOff * options_.gate_sigma, result);
    settled = settle(result);
  }
  // A wrong edge pulls the sights off: it goes first, and they are judged without it.
  if (settled && drop_edges(result)) settled = settle(result);
  if (!settled) {
    result.reason = Reason::kFilterFailed;
    return result;
  }
  drop_sights(touched_in_update_.sorted(), options_.gate_sigma, result);
  for (int l : touched_in_update_.sorted()) {
    FilterLandmark& landmark = landmarks_[l];
    correlation_sums_.set(l, landmark, poses_);
    if (landmark.measurements.empty()) continue;
    landmark.covariance = conditional_covariance(landmark);
  }
  correlation_ = correlation_sums_.correlation();
  touched_in_update_.clear();
  return result;
}

}  // namespace eifmap
