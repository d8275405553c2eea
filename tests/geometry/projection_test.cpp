#include "geometry/projection.h"

#include <gtest/gtest.h>

#include "support/numeric_jacobian.h"
#include "support/random.h"

namespace eifmap {
namespace {

using test::numeric_jacobian;
using test::Random;
using test::relative_difference;

// A camera anywhere and a point in front of it, up to 60 degrees off the axis.
struct View {
  Rigid3 world_from_camera;
  Eigen::Vector3d in_camera, point;
};

View random_view(Random& random) {
  View view;
  view.world_from_camera = {random.rotation(), 10 * random.normal_vector<3>()};
  const double depth = random.uniform(0.1, 50);
  view.in_camera = depth * Eigen::Vector3d(random.uniform(-1.7, 1.7), random.uniform(-1.7, 1.7), 1);
  view.point = view.world_from_camera * view.in_camera;
  return view;
}

TEST(Projection, IsThePinholeModel) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const View view = random_view(random);
    Eigen::Vector2d x;
    ASSERT_TRUE(project(view.world_from_camera, view.point, x));
    EXPECT_LT((x - view.in_camera.hnormalized()).norm(), 1e-10);
  }
}

TEST(Projection, RefusesWhatIsBehindOrBesideTheCamera) {
  const Rigid3 camera;
  Eigen::Vector2d x(7, 7);
  EXPECT_FALSE(project(camera, {0, 0, -1}, x));
  EXPECT_FALSE(project(camera, {0, 0, 0}, x));
  EXPECT_FALSE(project(camera, {1, 2, 0}, x));
  EXPECT_FALSE(project(camera, {1, 2, std::nan("")}, x));
  EXPECT_EQ(x, Eigen::Vector2d(7, 7));
}

TEST(Projection, JacobiansMatchNumericOnes) {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    const View view = random_view(random);
    Eigen::Vector2d x;
    Eigen::Matrix<double, 2, 6> d_pose;
    Eigen::Matrix<double, 2, 3> d_point;
    ASSERT_TRUE(project(view.world_from_camera, view.point, x, &d_pose, &d_point));

    const auto of_pose = [&](const Eigen::Matrix<double, 6, 1>& delta) {
      Eigen::Vector2d moved;
      project(retract(view.world_from_camera, delta.head<3>(), delta.tail<3>()), view.point, moved);
      return moved;
    };
    const auto of_point = [&](const Eigen::Vector3d& delta) {
      Eigen::Vector2d moved;
      project(view.world_from_camera, view.point + delta, moved);
      return moved;
    };
    EXPECT_LT(relative_difference(d_pose, numeric_jacobian<2, 6>(of_pose)), 1e-6);
    EXPECT_LT(relative_difference(d_point, numeric_jacobian<2, 3>(of_point)), 1e-6);
  }
}

}  // namespace
}  // namespace eifmap
