// The same bundle adjustment by the filter and by Ceres (S. Agarwal and others, ceres-solver.org):
// CPU time of an iteration of each, of the same measurements, robust loss, gauge and start.
#include <benchmark/benchmark.h>
#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <vector>

#include "support/long_way.h"

namespace eifmap::test {
namespace {

constexpr int kTimed = 5;        // iterations, after one that finds the order of elimination
constexpr int kToConverge = 50;  // at most

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

// One lap and ten keyframes, a little off.
struct Problem {
  struct Seen {
    int pose = 0, point = 0;
    Eigen::Vector2d x;
  };
  FilterOptions options;
  double pixel = 0, sigma = 0;
  std::vector<Rigid3> poses;
  std::vector<Eigen::Vector3d> points;
  std::vector<Seen> sights;
};

struct Values {
  std::vector<Rigid3> poses;
  std::vector<Eigen::Vector3d> points;
};

Problem make_problem() {
  const LongWay world = make_long_way(round_course(1010, 1000), {});
  Problem problem;
  problem.pixel = world.options.pixel;
  problem.sigma = world.options.noise_px * world.options.pixel;
  Random random(7);
  for (const Rigid3& pose : world.poses) {
    const bool is_gauge = problem.poses.size() < 2;  // the first baseline
    problem.poses.push_back(is_gauge ? pose
                                     : retract(pose, 0.001 * random.normal_vector<3>(),
                                               0.01 * random.normal_vector<3>()));
  }
  // As the filter has them: seen three times, and not all along one ray.
  std::vector<int> first(world.points.size(), -1), last = first, count(world.points.size(), 0);
  for (int p = 0; p < static_cast<int>(world.poses.size()); ++p)
    for (const PointSight& sight : world.sights[p]) {
      if (first[sight.point] < 0) first[sight.point] = p;
      last[sight.point] = p;
      ++count[sight.point];
    }
  const auto parallax = [&](int k) {
    const Eigen::Vector3d a = world.points[k] - world.poses[first[k]].translation;
    const Eigen::Vector3d b = world.points[k] - world.poses[last[k]].translation;
    return a.cross(b).norm() / (a.norm() * b.norm());
  };
  constexpr double kLeastParallax = 0.02;
  std::vector<int> number(world.points.size(), -1);
  for (int k = 0; k < static_cast<int>(world.points.size()); ++k) {
    if (count[k] < 3 || parallax(k) < kLeastParallax) continue;
    number[k] = static_cast<int>(problem.points.size());
    problem.points.push_back(world.points[k] + 0.02 * random.normal_vector<3>());
  }
  for (int p = 0; p < static_cast<int>(world.poses.size()); ++p)
    for (const PointSight& sight : world.sights[p])
      if (number[sight.point] >= 0) problem.sights.push_back({p, number[sight.point], sight.x});
  return problem;
}

const Problem& problem() {
  static const Problem one = make_problem();
  return one;
}

// Half the sum of Huber's loss.
double cost_of(const Problem& problem, const Values& values) {
  const double k = problem.options.huber_sigma;
  double cost = 0;
  for (const Problem::Seen& seen : problem.sights) {
    Eigen::Vector2d x;
    if (!project(values.poses[seen.pose], values.points[seen.point], x)) return INFINITY;
    const double error = (seen.x - x).norm() / problem.sigma;
    cost += error <= k ? 0.5 * error * error : k * (error - 0.5 * k);
  }
  return cost;
}

struct Run {
  double ms = 0;  // CPU, of an iteration: the median
  Values values;  // converged
};

Run by_filter(const Problem& problem) {
  FilterOptions options = problem.options;
  options.gate_sigma = 1e6;  // nothing is taken out
  InformationFilter filter(options, problem.pixel);
  for (const Rigid3& pose : problem.poses) filter.add_pose(pose);
  for (const Eigen::Vector3d& point : problem.points)
    filter.add_landmark(point, Eigen::Matrix3d::Zero());
  for (const Problem::Seen& seen : problem.sights)
    filter.add_measurement(seen.point, seen.pose, seen.x, problem.sigma);
  std::vector<double> ms;
  Run run;
  for (int i = 0; i < kToConverge; ++i) {
    const double before = cpu_seconds();
    const WholeIteration iteration = filter.iterate_whole();
    ms.push_back(1e3 * (cpu_seconds() - before));
    if (!iteration.ok) return run;
    if (i >= kTimed && iteration.squared_step < 1e-4) break;
  }
  run.ms = median({ms.begin() + 1, ms.begin() + 1 + kTimed});
  for (int p = 0; p < filter.num_poses(); ++p) run.values.poses.push_back(filter.pose(p));
  for (int l = 0; l < filter.num_landmarks(); ++l) run.values.points.push_back(filter.position(l));
  return run;
}

// Seven numbers of a pose: quaternion (x y z w), centre. The cost function's derivative is of the
// pose's error itself, with a seventh column of zeros; this manifold takes that off again.
class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* out) const override {
    const Eigen::Map<const Eigen::Quaterniond> q(x);
    Eigen::Map<Eigen::Quaterniond> turned(out);
    turned = (q * so3_exp(Eigen::Map<const Eigen::Vector3d>(delta))).normalized();
    for (int k = 0; k < 3; ++k) out[4 + k] = x[4 + k] + delta[3 + k];
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
  bool Minus(const double*, const double*, double*) const override { return false; }
  bool MinusJacobian(const double*, double*) const override { return false; }
};

// The second pose's: its centre does not leave the plane across the first baseline.
class SecondPoseManifold : public PoseManifold {
 public:
  explicit SecondPoseManifold(const Eigen::Vector3d& baseline)
      : across_(sphere_basis(baseline.normalized())) {}
  int TangentSize() const override { return 5; }
  bool Plus(const double* x, const double* delta, double* out) const override {
    Eigen::Matrix<double, 6, 1> step;
    step << delta[0], delta[1], delta[2], across_ * Eigen::Map<const Eigen::Vector2d>(delta + 3);
    return PoseManifold::Plus(x, step.data(), out);
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 5, Eigen::RowMajor>> j(jacobian);
    j.setZero();
    j.topLeftCorner<3, 3>().setIdentity();
    j.block<3, 2>(3, 3) = across_;
    return true;
  }

 private:
  Eigen::Matrix<double, 3, 2> across_;
};

class SightCost : public ceres::SizedCostFunction<2, 7, 3> {
 public:
  SightCost(const Eigen::Vector2d& x, double sigma) : x_(x), inverse_sigma_(1 / sigma) {}
  bool Evaluate(double const* const* values, double* residual, double** jacobians) const override {
    const Rigid3 pose(Eigen::Map<const Eigen::Quaterniond>(values[0]),
                      Eigen::Map<const Eigen::Vector3d>(values[0] + 4));
    const Eigen::Map<const Eigen::Vector3d> point(values[1]);
    Eigen::Vector2d predicted;
    Eigen::Matrix<double, 2, 6> d_pose;
    if (!project(pose, point, predicted, jacobians ? &d_pose : nullptr)) return false;
    Eigen::Map<Eigen::Vector2d> out(residual);
    out = inverse_sigma_ * (predicted - x_);
    if (!jacobians) return true;
    if (jacobians[0]) {
      Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>> j(jacobians[0]);
      j.leftCols<6>() = inverse_sigma_ * d_pose;
      j.col(6).setZero();
    }
    if (jacobians[1]) {
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> j(jacobians[1]);
      j = -inverse_sigma_ * d_pose.rightCols<3>();
    }
    return true;
  }

 private:
  Eigen::Vector2d x_;
  double inverse_sigma_;
};

class Clock : public ceres::IterationCallback {
 public:
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    const double now = cpu_seconds();
    ms.push_back(1e3 * (now - last_));
    last_ = now;
    return ceres::SOLVER_CONTINUE;
  }
  std::vector<double> ms;  // the first is of the evaluation at the start

 private:
  double last_ = cpu_seconds();
};

Run by_ceres(const Problem& problem) {
  std::vector<std::array<double, 7>> poses(problem.poses.size());
  for (std::size_t p = 0; p < poses.size(); ++p) {
    Eigen::Map<Eigen::Quaterniond>(poses[p].data()) = problem.poses[p].rotation;
    Eigen::Map<Eigen::Vector3d>(poses[p].data() + 4) = problem.poses[p].translation;
  }
  std::vector<Eigen::Vector3d> points = problem.points;
  PoseManifold any;
  SecondPoseManifold second(problem.poses[1].translation - problem.poses[0].translation);
  ceres::HuberLoss huber(problem.options.huber_sigma);
  ceres::Problem::Options shared;
  shared.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  shared.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem solved(shared);
  auto order = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t p = 0; p < poses.size(); ++p) {
    solved.AddParameterBlock(poses[p].data(), 7, p == 1 ? &second : &any);
    order->AddElementToGroup(poses[p].data(), 1);
  }
  solved.SetParameterBlockConstant(poses[0].data());
  for (Eigen::Vector3d& point : points) {
    solved.AddParameterBlock(point.data(), 3);
    order->AddElementToGroup(point.data(), 0);
  }
  for (const Problem::Seen& seen : problem.sights)
    solved.AddResidualBlock(new SightCost(seen.x, problem.sigma), &huber, poses[seen.pose].data(),
                            points[seen.point].data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.linear_solver_ordering = order;
  options.num_threads = 1;
  options.max_num_iterations = kToConverge;
  options.function_tolerance = 1e-9;
  options.gradient_tolerance = options.parameter_tolerance = 0;
  options.logging_type = ceres::SILENT;
  Clock clock;
  options.callbacks.push_back(&clock);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &solved, &summary);
  Run run;
  // Those after the first two: the start's evaluation, and the symbolic factorization.
  const auto begin = clock.ms.begin() + std::min<long>(2, static_cast<long>(clock.ms.size()) - 1);
  run.ms = median({begin, std::min(begin + kTimed, clock.ms.end())});
  for (const auto& pose : poses)
    run.values.poses.push_back({Eigen::Map<const Eigen::Quaterniond>(pose.data()),
                                Eigen::Map<const Eigen::Vector3d>(pose.data() + 4)});
  run.values.points = std::move(points);
  if (!summary.IsSolutionUsable()) run.values = {};
  return run;
}

void iteration_against_ceres(benchmark::State& state) {
  constexpr int kRuns = 5;
  constexpr double kSameCost = 1e-3;  // share
  for (auto _ : state) {
    std::vector<double> ours, theirs, ratio;
    for (int run = 0; run < kRuns; ++run) {
      const Run a = by_filter(problem()), b = by_ceres(problem());
      if (a.values.poses.empty() || b.values.poses.empty())
        return state.SkipWithError("one of them found no solution");
      const double cost_a = cost_of(problem(), a.values), cost_b = cost_of(problem(), b.values);
      if (!(std::abs(cost_a - cost_b) <= kSameCost * cost_b))
        return state.SkipWithError(("they end at different costs: " + std::to_string(cost_a) +
                                    " and " + std::to_string(cost_b))
                                       .c_str());
      ours.push_back(a.ms), theirs.push_back(b.ms), ratio.push_back(a.ms / b.ms);
      state.counters["cost"] = cost_a;
      state.counters["cost_ceres"] = cost_b;
    }
    state.counters["ms"] = median(ours);
    state.counters["ms_ceres"] = median(theirs);
    state.counters["ratio"] = median(ratio);
    state.counters["keyframes"] = static_cast<double>(problem().poses.size());
    state.counters["landmarks"] = static_cast<double>(problem().points.size());
    state.counters["observations"] = static_cast<double>(problem().sights.size());
  }
}
BENCHMARK(iteration_against_ceres)->Unit(benchmark::kSecond)->Iterations(1);

}  // namespace
}  // namespace eifmap::test

BENCHMARK_MAIN();
