// How an update finds the mean.
#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/information_filter.h"
#include "filter/latest_poses.h"

namespace eifmap {
namespace {

// Sigmas. A step delta that the gradient b asks for moves no linear function a of the poses by more
// than sqrt(delta'b) of its sigma: |a'delta| <= sqrt(a' S^-1 a) sqrt(b' S^-1 b). Below this, and
// where no landmark has further to go by itself, the mean stays.
constexpr double kConverged = 5e-4;
// Of one pose or landmark given all others. A smaller step is not worth looking at all that it
// moves: it stays in the right-hand side until it has grown.
constexpr double kStill = 1e-4;

// What comes with a keyframe may start far from where it belongs. First the latest poses alone find
// their places, while all others stand: the first steps of what is far off would else shake the
// whole map.
constexpr int kLatest = 25, kLatestIterations = 12;
// Sigmas: further off, nobody else is asked. Then it is, as long as most of the step, in squared
// sigmas, is theirs.
constexpr double kRough = 0.1, kMostly = 0.5;

// Keyframes of a map that the thresholds are for. The ways in which a map bends as a whole carry
// the less information the longer it is, while the errors of the frozen derivatives add up: in a
// larger map what is looked at is held that much closer.
constexpr double kSmall = 50;

// A step this much larger than the one before, in squared sigmas, says that the matrix was frozen
// too far from where the mean is.
constexpr double kGrown = 2;

}  // namespace

// Linearizes what is new and what moved; returns how many sights.
std::size_t InformationFilter::linearize_moved() {
  const bool once = options_.relinearize == Relinearize::kOnce;
  const Holding held = holding();
  std::size_t count = 0;
  for (int l : touched_.sorted()) {
    if (landmarks_[l].is_removed()) continue;
    FilterLandmark& landmark = landmarks_.write(l);
    for (PointMeasurement& m : landmark.measurements) {
      if (once && m.linearized) continue;
      if (!linearize(m, projectors_[m.pose], landmark.position, held, options_.huber_sigma))
        continue;
      landmark.changed = true;
      if (m.linearized) ++count;
    }
  }
  for (int e = 0; e < num_edges(); ++e) {
    if (edges_[e].stands()) continue;
    FilterEdge& edge = edges_.write(e);
    linearize(edge, poses_[edge.i], poses_[edge.j], options_.relinearize, edge_variance_);
  }
  for (FilterAbsolute& absolute : absolutes_) linearize_moved(absolute);
  return count;
}

void InformationFilter::linearize_all_anew() {
  for (int l = 0; l < num_landmarks(); ++l) {
    if (landmarks_[l].is_removed()) continue;
    FilterLandmark& landmark = landmarks_.write(l);
    landmark.changed = true;
    for (PointMeasurement& m : landmark.measurements) m.linearized = false;
    touch(l);
  }
  for (int e = 0; e < num_edges(); ++e) {
    FilterEdge& edge = edges_.write(e);
    edge.linearized = false, edge.changed = true;
  }
  for (FilterAbsolute& a : absolutes_) a.linearized = false, a.changed = true;
}

// The factor's pattern grows only.
bool InformationFilter::factor_for_all() {
  if (shrunk_) cholesky_ = SparseCholesky();
  shrunk_ = false;
  if (!cholesky_.factor(system_.matrix(), blocks().earth())) return false;
  system_.mark_factored();
  return true;
}

void InformationFilter::set_pose(int pose, const Rigid3& world_from_camera) {
  poses_[pose] = world_from_camera;
  projectors_[pose] = Projector(world_from_camera);
}

Holding InformationFilter::holding() const {
  if (options_.relinearize != Relinearize::kThreshold) return {};
  const double share = std::min(1.0, kSmall / (num_poses() - num_removed_));
  const double within = share * options_.relinearize_px * radians_per_pixel_;
  return {within, share * options_.relinearize_depth, within};
}

// The landmark to its best place while its poses stand; says whether it moved. Where that is far,
// or its robust weights change, it takes several steps: better here than of the whole map.
bool InformationFilter::move_alone(FilterLandmark& landmark, double still) const {
  constexpr int kSteps = 10;
  const Holding held = holding();
  for (int i = 0; i < kSteps; ++i) {
    const Eigen::Vector3d sigmas = step_alone_in_sigmas(landmark);
    const double length = sigmas.norm();
    if (length <= still) return i > 0;
    const Eigen::Vector3d step = landmark.r_inverse * sigmas;
    landmark.position += step;
    for (PointMeasurement& m : landmark.measurements)
      m.residual.noalias() -= m.now.to_landmark * step;
    if (options_.relinearize == Relinearize::kOnce || length <= kConverged) return true;
    bool anew = false;
    for (PointMeasurement& m : landmark.measurements)
      if (linearize(m, projectors_[m.pose], landmark.position, held, options_.huber_sigma))
        anew = true;
    if (!anew) continue;
    landmark.changed = true;
    factor_landmark(landmark);
  }
  return true;
}

// mu <- mu + delta, and the part of each residual that this explains is taken off it. A landmark's
// step is V^-1 (b - W' delta): what its poses' step leaves of the residuals.
void InformationFilter::apply(const Eigen::VectorXd& delta_poses) {
  // [WD10] (7) moves all.
  const double still = options_.relinearize == Relinearize::kOnce ? 0 : kStill;
  const auto step_of = [&](int pose) { return delta_poses.segment<6>(6 * blocks().of(pose)); };
  const auto is_step = [&](int pose) {
    const Eigen::Matrix<double, 6, 1> delta = step_of(pose);
    if (delta.isZero(0)) return false;  // not of the latest
    const PoseBlock& block = system_.matrix().column(blocks().of(pose)).block.back();
    return delta.dot(block * delta) > still * still;
  };
  std::vector<std::uint8_t> moves(poses_.size(), 0);
  for (int p = 1; p < num_poses(); ++p) {
    if (is_removed(p) || !is_step(p)) continue;
    moves[p] = 1;
    for (int l : index_.landmarks(p)) touch(l);
    set_pose(p, retract(poses_[p], step_of(p).head<3>(), step_of(p).tail<3>()));
  }
  const bool earth_moves = has_level() && is_step(kEarthFromMap);
  if (earth_moves)
    earth_from_map_ = retract(earth_from_map_, step_of(kEarthFromMap).head<3>(),
                              step_of(kEarthFromMap).tail<3>());
  const std::vector<int> in_question = touched_.sorted();
  touched_.clear();
  for (int l : in_question) {
    if (landmarks_[l].is_removed()) continue;
    FilterLandmark& landmark = landmarks_.write(l);
    const Eigen::Vector3d position_before = landmark.position;
    bool moved = false;
    for (PointMeasurement& m : landmark.measurements) {
      if (!moves[m.pose]) continue;
      m.residual.noalias() -= m.d_pose_now() * step_of(m.pose);
      moved = true;
    }
    if (move_alone(landmark, moved ? 0 : still)) moved = true;
    if (moved) touch(l, position_before);
  }
  for (int e = 0; e < num_edges(); ++e) {
    if (!moves[edges_[e].i] && !moves[edges_[e].j]) continue;
    FilterEdge& edge = edges_.write(e);
    Eigen::Matrix<double, 5, 1>& residual = edge.now.residual;
    if (moves[edge.i]) residual.noalias() -= edge.now.d_i * step_of(edge.i);
    if (moves[edge.j]) residual.noalias() -= edge.now.d_j * step_of(edge.j);
    edge.moved = true;
  }
  for (FilterAbsolute& absolute : absolutes_) {
    for (const PoseRows& rows : absolute.now.of_pose) {
      if (rows.pose == kEarthFromMap ? !earth_moves : !moves[rows.pose]) continue;
      absolute.now.residual.noalias() -= rows.derivative * step_of(rows.pose);
      absolute.moved = true;
    }
  }
}

void InformationFilter::undo() {
  cholesky_ = SparseCholesky();
  for (int p = 0; p < num_poses(); ++p) set_pose(p, poses_before_[p]);
  earth_from_map_ = earth_before_;
  for (const auto& [landmark, position] : positions_before_)
    if (!landmarks_[landmark].is_removed()) landmarks_.write(landmark).position = position;
  linearize_all_anew();
}

// The latest poses' own step, or that of all. False when the matrix cannot be factored. The step
// of all is b'S^-1 b = |L^-1 b|^2 long: where that is too little to be taken, half a solve tells.
bool InformationFilter::next_step(bool ask_latest, Step& step) {
  const double of_landmarks = std::pow(system_.largest_step_alone(), 2);
  step = {{}, 0, false};
  if (ask_latest &&
      solve_latest(system_.matrix(), system_.right_side(), kLatest, blocks().earth(), step.delta))
    step.squared = step.delta.dot(system_.right_side()) + of_landmarks;
  if (step.squared > kRough * kRough) return true;
  if (!factor_for_all()) return false;
  const Eigen::VectorXd whitened = cholesky_.whiten_column(system_.right_side());
  if (!whitened.allFinite()) return false;
  const double squared = whitened.squaredNorm() + of_landmarks;
  const bool done = squared <= kConverged * kConverged;
  if (!done && step.squared > kMostly * squared) return true;
  step = {{}, squared, true};
  if (!done || options_.relinearize == Relinearize::kOnce)
    step.delta = cholesky_.solve_whitened(whitened);
  return true;
}

WholeIteration InformationFilter::iterate_whole() {
  linearize_all_anew();
  linearize_moved();
  system_.sum(index_, landmarks_, touched_.sorted(), edges_, absolutes_,
              poses_[1].translation - poses_[0].translation);
  if (!factor_for_all()) return {};
  const Eigen::VectorXd whitened = cholesky_.whiten_column(system_.right_side());
  if (!whitened.allFinite()) return {};
  const double squared = whitened.squaredNorm() + std::pow(system_.largest_step_alone(), 2);
  apply(cholesky_.solve_whitened(whitened));
  return {true, squared};
}

// False, with the mean as it was before the update, when the matrix cannot be factored.
bool InformationFilter::settle(FilterUpdate& update) {
  if (shrunk_ && system_.drop_removed(num_poses())) cholesky_ = SparseCholesky();
  const bool once = options_.relinearize == Relinearize::kOnce;
  int left_of_latest = once || num_poses() <= kLatest + 1 ? 0 : kLatestIterations;
  int left_of_all = options_.max_iterations;
  Step before{{}, std::numeric_limits<double>::infinity(), false};
  while (true) {
    update.relinearized += linearize_moved();
    system_.sum(index_, landmarks_, touched_.sorted(), edges_, absolutes_,
                poses_[1].translation - poses_[0].translation);
    Step step;
    if (!next_step(left_of_latest > 0, step)) {
      undo();
      return false;
    }
    const bool converged = !once && step.of_all && step.squared <= kConverged * kConverged;
    if (converged) touched_.clear();
    if (converged || (step.of_all && left_of_all == 0)) return true;
    const bool grown = step.of_all == before.of_all && step.squared > kGrown * before.squared;
    if (grown && !once) {
      linearize_all_anew();
      left_of_latest = 0;
      before.squared = std::numeric_limits<double>::infinity();
      continue;
    }
    apply(step.delta);
    if (step.of_all) ++update.iterations;
    if (once) {
      linearize_moved();  // the edges' errors at the mean
      return true;
    }
    step.of_all ? --left_of_all : --left_of_latest;
    if (step.of_all) left_of_latest = 0;
    // A latest pose's step may grow when a sight comes into view or gets its weight: not beyond the
    // first.
    if (step.of_all || std::isinf(before.squared)) before = std::move(step);
  }
}

}  // namespace eifmap
