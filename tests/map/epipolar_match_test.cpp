#include "map/epipolar_match.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <set>

#include "support/map_scene.h"

namespace eifmap::test {
namespace {

// Matches of all features of Omega_m of two views of one world.
struct Pair {
  ObservedFrame i, j;
  std::vector<Match> matches;
};

Pair match_views(const SyntheticStream& world, const Rigid3& pose_i, const Rigid3& pose_j) {
  Pair pair{observed_view(world, 0, pose_i), observed_view(world, 1, pose_j), {}};
  pair.matches = match_along_epipolar_lines(pair.i, pair.i.minus.index, pair.j, pair.j.minus.index,
                                            pose_i, pose_j, {});
  return pair;
}

TEST(EpipolarMatch, FindsTheTrueMatchesAndNoOthers) {
  const SyntheticStream world;
  const Pair pair = match_views(world, scene_pose(0), scene_pose(2));
  EXPECT_GT(pair.matches.size(), 60u);
  for (const Match& m : pair.matches) {
    // In this world a point's response is its name.
    EXPECT_EQ(pair.i.frame.keypoints[m.a].response, pair.j.frame.keypoints[m.b].response);
  }
}

TEST(EpipolarMatch, GivesPointsInFrontOfBothCameras) {
  // Half of the features look like another point, which may lie on their line behind the cameras.
  const SyntheticStream world(5);
  const MapperOptions options;
  const auto view = [&](int i) {
    return observe(world.view(i, scene_pose(i), 0.5), synthetic_camera(), MapSign::kMinus,
                   options.sigma_factor);
  };
  int found = 0;
  for (int k = 1; k < 8; ++k) {
    const ObservedFrame i = view(0), j = view(k);
    for (const Match& m : match_along_epipolar_lines(
             i, i.minus.index, j, j.minus.index, scene_pose(0), scene_pose(k), {50, 0.8, 0.6})) {
      const Rigid3 j_from_i = scene_pose(k).inverse() * scene_pose(0);
      const Eigen::Vector3d ray_j = j.x[m.b].homogeneous();
      const Eigen::Vector3d ray_i = j_from_i.rotation * i.x[m.a].homogeneous();
      // z_j ray_j - z_i ray_i = t, in least squares.
      Eigen::Matrix<double, 3, 2> rays;
      rays << ray_j, -ray_i;
      const Eigen::Vector2d depths = rays.colPivHouseholderQr().solve(j_from_i.translation);
      // Infinity is in front, and noise may put a far point a little beyond it.
      EXPECT_GT(1 / depths[1], -0.05) << k;
      ++found;
    }
  }
  EXPECT_GT(found, 50);
}

TEST(EpipolarMatch, UsesEachFeatureOnce) {
  const SyntheticStream world;
  const Pair pair = match_views(world, scene_pose(0), scene_pose(1));
  std::set<int> a, b;
  for (const Match& m : pair.matches) EXPECT_TRUE(a.insert(m.a).second && b.insert(m.b).second);
}

TEST(EpipolarMatch, FindsNothingAlongWrongLines) {
  const SyntheticStream world;
  const ObservedFrame i = observed_view(world, 0, scene_pose(0));
  const ObservedFrame j = observed_view(world, 1, scene_pose(2));
  // As if the camera had moved upwards: the lines run across the true motion.
  const Rigid3 wrong({1, 0, 0, 0}, {0, 1, 0});
  const auto matches =
      match_along_epipolar_lines(i, i.minus.index, j, j.minus.index, scene_pose(0), wrong, {});
  EXPECT_LT(matches.size(), 15u);
}

TEST(EpipolarMatch, RefusesCoincidingCentres) {
  const SyntheticStream world;
  const ObservedFrame i = observed_view(world, 0, scene_pose(0));
  EXPECT_THROW(match_along_epipolar_lines(i, i.minus.index, i, i.minus.index, scene_pose(0),
                                          scene_pose(0), {}),
               std::invalid_argument);
}

}  // namespace
}  // namespace eifmap::test
