#include "geometry/triangulation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "support/random.h"

namespace eifmap {
namespace {

using test::Random;

constexpr double kSigma = 1.0 / 500;  // one pixel

Rigid3 camera_at(double x, double y, double z) {
  return {Eigen::Quaterniond::Identity(), {x, y, z}};
}

// `point` seen from each pose, with noise of `noise` sigmas.
std::vector<Sighting> sightings_of(const Eigen::Vector3d& point, const std::vector<Rigid3>& poses,
                                   double noise, Random& random) {
  std::vector<Sighting> sightings;
  for (const Rigid3& pose : poses) {
    const Eigen::Vector2d x = (pose.inverse() * point).hnormalized();
    sightings.push_back({pose, x + noise * kSigma * random.normal_vector<2>(), kSigma});
  }
  return sightings;
}

TEST(Triangulation, FindsTheExactPoint) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d point(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(4, 9));
    std::vector<Rigid3> poses;
    for (int v = 0; v < 2 + i % 5; ++v)
      poses.emplace_back(so3_exp(0.1 * random.normal_vector<3>()), 0.5 * random.normal_vector<3>());
    const TriangulatedPoint found = triangulate(sightings_of(point, poses, 0, random));
    ASSERT_TRUE(found.valid);
    EXPECT_LT((found.point - point).norm(), 1e-5 * point.norm());
    EXPECT_LT(found.max_error, 1e-3);
  }
}

TEST(Triangulation, ParallaxIsTheWidestAngle) {
  Random random(1);
  const Eigen::Vector3d point(0, 0, 1);
  const TriangulatedPoint found = triangulate(sightings_of(
      point, {camera_at(0, 0, 0), camera_at(0.1, 0, 0), camera_at(1, 0, 0)}, 0, random));
  EXPECT_NEAR(found.max_parallax, M_PI / 4, 1e-9);
}

// The covariance is honest: the error, whitened by it, has the square norm of three normals.
TEST(Triangulation, CovarianceIsConsistent) {
  Random random(2);
  double sum = 0;
  constexpr int kRuns = 2000;
  for (int i = 0; i < kRuns; ++i) {
    const Eigen::Vector3d point(random.uniform(-2, 2), random.uniform(-1, 1), random.uniform(4, 8));
    const std::vector<Rigid3> poses{camera_at(0, 0, 0), camera_at(0.6, 0, 0),
                                    camera_at(1.2, 0.1, 0), camera_at(1.0, 0, 0.5)};
    const TriangulatedPoint found = triangulate(sightings_of(point, poses, 1, random));
    ASSERT_TRUE(found.valid);
    const Eigen::Vector3d error = found.point - point;
    sum += error.dot(found.covariance.llt().solve(error));
  }
  EXPECT_NEAR(sum / kRuns, 3, 0.2);  // standard error sqrt(6 / 2000) = .055
}

TEST(Triangulation, DepthSigmaIsThatOfTheLastView) {
  Random random(3);
  const Eigen::Vector3d point(0, 0, 10);
  // Two views a metre apart at ten metres: sigma_Z / Z = sqrt(2) sigma Z / b.
  const TriangulatedPoint far =
      triangulate(sightings_of(point, {camera_at(-0.5, 0, 0), camera_at(0.5, 0, 0)}, 0, random));
  EXPECT_NEAR(far.relative_depth_sigma, std::sqrt(2) * kSigma * 10,
              0.01 * far.relative_depth_sigma);
}

TEST(Triangulation, RefusesWhatIsNotAPoint) {
  Random random(4);
  const Eigen::Vector3d point(0, 0, 5);
  EXPECT_FALSE(triangulate({}).valid);
  EXPECT_FALSE(triangulate(sightings_of(point, {camera_at(0, 0, 0)}, 0, random)).valid);
  // No baseline at all
  EXPECT_FALSE(
      triangulate(sightings_of(point, {camera_at(0, 0, 0), camera_at(0, 0, 0)}, 0, random)).valid);
  // Rays that part: the point would be behind
  std::vector<Sighting> parting{{camera_at(0, 0, 0), {-0.1, 0}, kSigma},
                                {camera_at(1, 0, 0), {0.1, 0}, kSigma}};
  EXPECT_FALSE(triangulate(parting).valid);
  // A sigma that is none
  std::vector<Sighting> bad =
      sightings_of(point, {camera_at(0, 0, 0), camera_at(1, 0, 0)}, 0, random);
  bad[0].sigma = 0;
  EXPECT_FALSE(triangulate(bad).valid);
}

TEST(Triangulation, ShowsASightingThatDisagrees) {
  Random random(5);
  const Eigen::Vector3d point(0, 0, 5);
  std::vector<Sighting> sightings = sightings_of(
      point, {camera_at(0, 0, 0), camera_at(1, 0, 0), camera_at(0.5, 0.3, 0)}, 0, random);
  sightings[1].x.y() += 30 * kSigma;
  const TriangulatedPoint found = triangulate(sightings);
  ASSERT_TRUE(found.valid);
  EXPECT_GT(found.max_error, 10);
}

}  // namespace
}  // namespace eifmap
