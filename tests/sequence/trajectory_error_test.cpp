#include "sequence/trajectory_error.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>

#include "sequence/temporary_folder.h"

namespace eifmap {
namespace {

class Random {
 public:
  explicit Random(int seed) : engine_(seed) {}
  double normal() { return normal_(engine_); }
  double uniform() { return std::uniform_real_distribution<double>()(engine_); }
  Eigen::Vector3d vector(double sigma) {
    return {sigma * normal(), sigma * normal(), sigma * normal()};
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

std::vector<TumPose> random_walk(Random& random, int count) {
  std::vector<TumPose> poses;
  Rigid3 pose({1, 0, 0, 0}, random.vector(10));
  for (int i = 0; i < count; ++i) {
    pose =
        pose * Rigid3(so3_exp(random.vector(0.1)), Eigen::Vector3d(0, 0, 0.3) + random.vector(0.1));
    poses.push_back({50 + 0.04 * i + 0.01 * random.uniform(), pose});
  }
  return poses;
}

TumPose transformed(const Similarity& s, const TumPose& pose) {
  return {pose.time_s,
          {Eigen::Quaterniond(s.rotation) * pose.world_from_camera.rotation,
           s * pose.world_from_camera.translation}};
}

Similarity random_similarity(Random& random) {
  return {0.2 + 3 * random.uniform(), so3_exp(random.vector(1)).toRotationMatrix(),
          random.vector(20)};
}

TEST(TrajectoryError, IsZeroForAMovedTurnedAndScaledCopy) {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const auto truth = random_walk(random, 100);
    const auto estimate_from_truth = random_similarity(random);
    std::vector<TumPose> estimate;
    for (const auto& pose : truth) estimate.push_back(transformed(estimate_from_truth, pose));
    const auto error = trajectory_error(truth, estimate, {0.05, 200});
    ASSERT_TRUE(error.aligned);
    EXPECT_EQ(error.matched, 100);
    EXPECT_DOUBLE_EQ(error.coverage.value(), 0.5);
    EXPECT_LT(error.max_m, 1e-10);
    EXPECT_LT(error.rotation_rmse_deg, 1e-4);
    EXPECT_NEAR(error.truth_from_estimate.scale * estimate_from_truth.scale, 1, 1e-12);
    EXPECT_NEAR(error.covered_path_m, error.path_m, 1e-9);
  }
}

TEST(TrajectoryError, NoOtherSimilarityIsBetter) {
  Random random(2);
  Eigen::Matrix3Xd a(3, 30), b(3, 30);
  const auto truth = random_similarity(random);
  for (int k = 0; k < 30; ++k) {
    b.col(k) = random.vector(5);
    a.col(k) = truth * b.col(k) + random.vector(0.5);
  }
  const auto cost = [&](const Similarity& s) {
    double sum = 0;
    for (int k = 0; k < 30; ++k) sum += (a.col(k) - s * b.col(k)).squaredNorm();
    return sum;
  };
  const auto best = fit_similarity(a, b);
  EXPECT_NEAR(best.rotation.determinant(), 1, 1e-12);
  for (int trial = 0; trial < 500; ++trial) {
    Similarity other = best;
    other.rotation = best.rotation * so3_exp(random.vector(0.01)).toRotationMatrix();
    other.scale *= 1 + 0.01 * random.normal();
    other.translation += random.vector(0.05);
    EXPECT_GE(cost(other), cost(best));
  }
  EXPECT_THROW(fit_similarity(a, Eigen::Matrix3Xd(3, 29)), std::invalid_argument);
}

TEST(TrajectoryError, AMirroredPathIsNotARotation) {
  Random random(3);
  const auto truth = random_walk(random, 50);
  auto estimate = truth;
  for (auto& pose : estimate) pose.world_from_camera.translation.x() *= -1;
  const auto error = trajectory_error(truth, estimate, {});
  EXPECT_NEAR(error.truth_from_estimate.rotation.determinant(), 1, 1e-12);
  EXPECT_GT(error.rmse_m, 0.01);
}

TEST(TrajectoryError, TooLittleToAlignIsSaidSo) {
  Random random(4);
  const auto truth = random_walk(random, 20);
  EXPECT_FALSE(trajectory_error(truth, {}, {}).aligned);
  EXPECT_FALSE(trajectory_error(truth, std::span(truth).first(2), {}).aligned);
  std::vector<TumPose> still(truth.begin(), truth.end());
  for (auto& pose : still) pose.world_from_camera.translation.setZero();
  EXPECT_FALSE(trajectory_error(truth, still, {}).aligned);
  auto late = truth;
  for (auto& pose : late) pose.time_s += 100;
  EXPECT_EQ(trajectory_error(truth, late, {}).matched, 0);
}

std::string output_of(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  std::array<char, 4096> buffer;
  while (pipe && fgets(buffer.data(), buffer.size(), pipe.get())) text += buffer.data();
  return text;
}

// Debian's, whose numpy docker/packages.txt asks for; another python3 may come first in the path.
constexpr const char* kPython = "/usr/bin/python3";

// The tool that the figures of others were made with.
TEST(TrajectoryError, SameFiguresAsTheReferenceTool) {
  const char* shared = std::getenv("EIFMAP_SHARED");
  const std::filesystem::path root = shared
                                         ? std::filesystem::path(shared)
                                         : std::filesystem::path(EIFMAP_SOURCE_DIR) / "../shared";
  const auto tool = root / "tools" / "trajectory_error.py";
  if (!std::filesystem::exists(tool)) GTEST_SKIP() << "skipped: no " << tool;
  if (output_of(std::string(kPython) + " -c 'import numpy; print(1)' 2>/dev/null") != "1\n")
    GTEST_SKIP() << "skipped: no python3-numpy";
  Random random(5);
  const TemporaryFolder folder;
  for (int trial = 0; trial < 6; ++trial) {
    // The truth every 0.04, 0.08 or 0.12 s (too far apart to interpolate), sometimes with a gap;
    // the estimate noisy, with frames left out and some twice.
    auto truth = random_walk(random, 300);
    if (trial % 2 == 1) truth.erase(truth.begin() + 100, truth.begin() + 160);
    std::vector<TimedPose> estimate, truth_as_written;
    const auto moved = random_similarity(random);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (i % (1 + static_cast<std::size_t>(trial) % 3) == 0)
        truth_as_written.push_back(
            {std::llround(truth[i].time_s * 1e6), truth[i].world_from_camera});
      if (random.uniform() < 0.3) continue;
      auto pose = transformed(moved, truth[i]).world_from_camera;
      pose = pose * Rigid3(so3_exp(random.vector(0.05)), random.vector(0.3));
      estimate.push_back({std::llround((truth[i].time_s + 0.01 * random.normal()) * 1e6), pose});
      if (random.uniform() < 0.05) estimate.push_back(estimate.back());
    }
    const auto gt = folder.path() / "gt.tum", est = folder.path() / "est.tum";
    ASSERT_EQ(write_tum(gt, truth_as_written), "");
    ASSERT_EQ(write_tum(est, estimate), "");
    const auto wanted = nlohmann::json::parse(output_of(std::string(kPython) + " " + tool.string() +
                                                        " --gt " + gt.string() + " --est " +
                                                        est.string() + " --nframes 300 --json"));
    const auto got = nlohmann::json::parse(
        json_text(trajectory_error(read_tum(gt).poses, read_tum(est).poses, {0.05, 300})));
    ASSERT_EQ(got.size(), wanted.size());
    ASSERT_TRUE(got.contains("ate_rmse_m"));
    for (const auto& [name, value] : wanted.items())
      EXPECT_NEAR(got.at(name).get<double>(), value.get<double>(),
                  1e-9 * std::abs(value.get<double>()))
          << name;
  }
}

}  // namespace
}  // namespace eifmap
