#include "filter/information_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "geometry/robust.h"

namespace eifmap {
namespace {

// Chi-square of 5 degrees of freedom, 1 in 100,000: an edge beyond it contradicts the map.
constexpr double kEdgeGate = 30.9;

// What edges claim of themselves, against what the map, whose features have many more sights, says
// of them: 1 where they are right, more where whatever disturbs the images (a calibration that is
// off, a rolling shutter) is in no keypoint's sigma. From the median, which a few wrong edges do
// not move; as if kTrusted edges more had been right.
double variance_of_edges(const FilterEdges& edges) {
  constexpr double kMedianOfChi5 = 4.351, kTrusted = 10, kLargest = 16;
  std::vector<double> errors;
  for (const FilterEdge& edge : edges)
    if (edge.linearized) errors.push_back(edge.squared_error);
  const auto n = static_cast<double>(errors.size());
  const double factor = (kTrusted + n * take_median(errors) / kMedianOfChi5) / (kTrusted + n);
  return std::clamp(factor, 1.0, kLargest);
}

bool is_of(const FilterAbsolute& absolute, int pose) {
  const std::vector<RigidPoint>& points = absolute.observation.points;
  return std::any_of(points.begin(), points.end(),
                     [pose](const RigidPoint& point) { return point.pose == pose; });
}

bool is_between(const FilterAbsolute& absolute, int landmark) {
  const std::array<int, 2>& of = absolute.observation.landmarks;
  return absolute.observation.kind == AbsoluteObservation::Kind::kLandmarks &&
         (of[0] == landmark || of[1] == landmark);
}

}  // namespace

InformationFilter::InformationFilter(const FilterOptions& options, double radians_per_pixel)
    : options_(options), radians_per_pixel_(radians_per_pixel) {}

int InformationFilter::add_pose(const Rigid3& world_from_camera) {
  poses_.push_back(world_from_camera);
  projectors_.emplace_back(world_from_camera);
  removed_.push_back(0);
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
  if (pose < 0 || pose >= num_poses() || is_removed(pose) || !(sigma > 0))
    throw std::invalid_argument("InformationFilter: no such pose, or sigma not positive");
  PointMeasurement measurement;
  measurement.pose = pose;
  measurement.x = x;
  measurement.sigma = sigma;
  if (landmark < 0 || landmark >= num_landmarks())
    throw std::out_of_range("InformationFilter: no such landmark");
  FilterLandmark& of = landmarks_.write(landmark);
  of.measurements.push_back(measurement);
  of.changed = true;
  index_.add(pose, landmark);
  touch(landmark);
}

void InformationFilter::touch(int landmark) {
  touch(landmark, landmarks_[landmark].position);
}

void InformationFilter::touch(int landmark, const Eigen::Vector3d& position_before) {
  touched_.insert(landmark);
  if (touched_in_update_.insert(landmark)) positions_before_.push_back({landmark, position_before});
}

template <class Predicate>
void InformationFilter::remove_measurements(int landmark, Predicate predicate) {
  const std::vector<PointMeasurement>& all = landmarks_.at(landmark).measurements;
  if (std::none_of(all.begin(), all.end(), predicate)) return;
  system_.before_removal(landmarks_[landmark]);
  for (const PointMeasurement& m : all)
    if (predicate(m)) index_.remove(m.pose, landmark);
  FilterLandmark& of = landmarks_.write(landmark);
  std::erase_if(of.measurements, predicate);
  of.changed = true;
  touch(landmark);
  if (!of.is_removed()) return;
  landmarks_.reset(landmark);  // its handle stays, and there may be many such
  correlation_sums_.remove(landmark);
  remove_absolutes([landmark](const FilterAbsolute& a) { return is_between(a, landmark); });
}

template <class Predicate>
void InformationFilter::remove_absolutes(Predicate predicate) {
  std::erase_if(absolutes_, [&](const FilterAbsolute& absolute) {
    if (!predicate(absolute)) return false;
    system_.before_removal(absolute);
    return true;
  });
}

void InformationFilter::remove_measurement(int landmark, int pose) {
  remove_measurements(landmark, [pose](const PointMeasurement& m) { return m.pose == pose; });
}

void InformationFilter::remove_landmark(int landmark) {
  remove_measurements(landmark, [](const PointMeasurement&) { return true; });
}

void InformationFilter::scale_sigmas(double factor) {
  if (!(factor > 0)) throw std::invalid_argument("InformationFilter: factor not positive");
  for (int l = 0; l < num_landmarks(); ++l) {
    if (landmarks_[l].is_removed()) continue;
    for (PointMeasurement& m : landmarks_.write(l).measurements) m.sigma *= factor;
  }
  for (int e = 0; e < num_edges(); ++e) edges_.write(e).measurement.sqrt_information /= factor;
  // What the map's covariances were multiplied by is, as far as that goes, in the sigmas now.
  const double squared = factor * factor;
  map_variance_ = std::max(1.0, map_variance_ / squared);
  for (VarianceAskedFor& v : variances_asked_for_) v.by_median /= squared, v.by_tenth /= squared;
  linearize_all_anew();
}

void InformationFilter::remove_pose(int pose) {
  if (pose < 2 || pose >= num_poses() || is_removed(pose))
    throw std::invalid_argument("InformationFilter: no such pose, or of the gauge");
  const std::vector<int> seen = index_.landmarks(pose);
  for (int landmark : seen) remove_measurement(landmark, pose);
  const auto ends_in = [pose](const FilterEdge& edge) { return edge.i == pose || edge.j == pose; };
  for (const FilterEdge& edge : edges_)
    if (ends_in(edge)) system_.before_removal(edge);
  edges_.erase_if(ends_in);
  remove_absolutes([pose](const FilterAbsolute& absolute) { return is_of(absolute, pose); });
  system_.remove(pose);
  removed_[pose] = 1;
  ++num_removed_;
  shrunk_ = true;
}

void InformationFilter::carry(int removed_pose, const Rigid3& world_from_camera) {
  if (!is_removed(removed_pose))
    throw std::invalid_argument("InformationFilter: the pose is still measured");
  set_pose(removed_pose, world_from_camera);
}

void InformationFilter::move(const std::vector<Rigid3>& poses,
                             const std::vector<std::pair<int, Eigen::Vector3d>>& positions) {
  const auto is_first = [this](const Rigid3& pose) {
    return pose.translation == poses_[0].translation &&
           pose.rotation.coeffs() == poses_[0].rotation.coeffs();
  };
  if (!has_gauge_ || poses.size() != poses_.size() || !is_first(poses[0]))
    throw std::invalid_argument("InformationFilter::move: no gauge, or not of all poses");
  for (const Rigid3& pose : poses)
    if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite())
      throw std::invalid_argument("InformationFilter::move: a pose is not finite");
  for (const auto& [landmark, position] : positions)
    if (landmark < 0 || landmark >= num_landmarks() || !position.allFinite())
      throw std::invalid_argument("InformationFilter::move: no such landmark, or not finite");
  for (int p = 1; p < num_poses(); ++p)
    if (!is_removed(p)) set_pose(p, poses[p]);
  for (const auto& [landmark, position] : positions) landmarks_.write(landmark).position = position;
  for (auto& [landmark, position] : positions_before_) position = landmarks_[landmark].position;
  linearize_all_anew();
}

bool InformationFilter::has_absolute(int pose, AbsoluteObservation::Kind kind) const {
  return std::any_of(absolutes_.begin(), absolutes_.end(), [&](const FilterAbsolute& absolute) {
    return absolute.observation.kind == kind && is_of(absolute, pose);
  });
}

bool InformationFilter::has_absolute(AbsoluteObservation::Kind kind) const {
  return std::any_of(absolutes_.begin(), absolutes_.end(), [kind](const FilterAbsolute& absolute) {
    return absolute.observation.kind == kind;
  });
}

int InformationFilter::num_distances(int landmark) const {
  return static_cast<int>(
      std::count_if(absolutes_.begin(), absolutes_.end(),
                    [landmark](const FilterAbsolute& a) { return is_between(a, landmark); }));
}

bool InformationFilter::add_edge(int i, int j, const RelativePose& pose) {
  check_ends(i, j);
  RelativePoseMeasurement measurement;
  if (!make_measurement(pose, measurement)) return false;
  add_edge(i, j, measurement);
  return true;
}

void InformationFilter::add_edge(int i, int j, const RelativePoseMeasurement& measurement) {
  check_ends(i, j);
  FilterEdge edge;
  edge.i = i;
  edge.j = j;
  edge.measurement = measurement;
  edges_.push_back(edge);
}

void InformationFilter::check_ends(int i, int j) const {
  if (i == j || std::min(i, j) < 0 || std::max(i, j) >= num_poses() || is_removed(i) ||
      is_removed(j))
    throw std::invalid_argument("InformationFilter: an edge needs two known poses");
}

std::size_t InformationFilter::num_measurements() const {
  std::size_t n = 0;
  for (const FilterLandmark& landmark : landmarks_) n += landmark.measurements.size();
  return n;
}

double InformationFilter::error(int landmark, const PointMeasurement& measurement) const {
  Eigen::Vector2d predicted;
  if (!projectors_[measurement.pose](landmarks_[landmark].position, predicted))
    return std::numeric_limits<double>::infinity();
  return (measurement.x - predicted).norm() / measurement.sigma;
}

// Whether a measured landmark, which the scale may rest on, would be left with less than its place
// takes.
template <class Predicate>
bool InformationFilter::must_stay(int landmark, Predicate is_off) const {
  const std::vector<PointMeasurement>& all = landmarks_[landmark].measurements;
  const auto off = static_cast<std::size_t>(std::count_if(all.begin(), all.end(), is_off));
  return off > 0 && all.size() - off < 2 && num_distances(landmark) > 0;
}

void InformationFilter::drop_sights(const std::vector<int>& landmarks, double gate,
                                    FilterUpdate& update) {
  for (int l : landmarks) {
    const auto is_off = [&](const PointMeasurement& m) { return !(error(l, m) <= gate); };
    const std::size_t before = update.dropped.size();
    for (const PointMeasurement& m : landmarks_[l].measurements)
      if (is_off(m)) update.dropped.push_back({l, m.pose});
    if (update.dropped.size() == before) continue;  // as of most: nothing is looked at twice
    if (must_stay(l, is_off))
      update.dropped.resize(before);
    else
      remove_measurements(l, is_off);
  }
}

bool InformationFilter::drop_edges(FilterUpdate& update) {
  const auto is_wrong = [](const FilterEdge& edge) { return edge.squared_error > kEdgeGate; };
  for (const FilterEdge& edge : edges_)
    if (is_wrong(edge)) system_.before_removal(edge);
  const std::size_t dropped = edges_.erase_if(is_wrong);
  update.dropped_edges += static_cast<int>(dropped);
  return dropped > 0;
}

// A new estimate of it concerns every edge, so a slightly other one is not worth it.
void InformationFilter::judge_edges() {
  constexpr double kAsGood = 1.1;
  // After scale_sigmas() there is nothing to judge by until they are linearized again.
  if (std::none_of(edges_.begin(), edges_.end(), [](const FilterEdge& e) { return e.linearized; }))
    return;
  const double variance = variance_of_edges(edges_);
  if (variance < kAsGood * edge_variance_ && edge_variance_ < kAsGood * variance) return;
  edge_variance_ = variance;
  for (int e = 0; e < num_edges(); ++e) edges_.write(e).changed = true;
}

void InformationFilter::judge_newest(FilterUpdate& update) const {
  constexpr std::size_t kSeenWell = 4;  // sights: a landmark gives way to fewer
  const int newest = num_poses() - 1;
  std::vector<double> errors;
  for (int l : index_.landmarks(newest))
    for (const PointMeasurement& m : landmarks_[l].measurements)
      if (m.pose == newest && landmarks_[l].measurements.size() >= kSeenWell)
        errors.push_back(error(l, m));
  update.num_newest = static_cast<int>(errors.size());
  update.newest_spread = kSpreadFromMedian2d * take_median(errors);
}

// What its sights say of errors, and it itself given the poses, as of its linearization.
void InformationFilter::judge_landmark(int l) {
  if (landmarks_[l].is_removed()) return;
  FilterLandmark& landmark = landmarks_.write(l);
  correlation_sums_.set(l, landmark, poses_);
  landmark.covariance = conditional_covariance(landmark);
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
  judge_absolutes();
  poses_before_ = poses_;
  earth_before_ = earth_from_map_;
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
  judge_newest(result);
  drop_sights(touched_in_update_.sorted(), options_.gate_sigma, result);
  for (int l : touched_in_update_.sorted()) judge_landmark(l);
  correlation_ = correlation_sums_.correlation();
  touched_in_update_.clear();
  positions_before_.clear();
  poses_before_ = {};
  return result;
}

}  // namespace eifmap
