#include "simulation/renderer.h"

#include <gtest/gtest.h>

#include <random>

namespace eifmap::simulation {
namespace {

Camera small_camera() {
  Camera camera;
  camera.width = 160;
  camera.height = 120;
  camera.fx = 150;
  camera.fy = 140;
  camera.cx = 79.5;
  camera.cy = 59.5;
  return camera;
}

// A surface whose every point is as bright as `gray` of 255 says.
Quad plain(Quad quad, float gray) {
  quad.painter = [gray](float, float) { return gray / 255; };
  quad.lit = false;
  quad.texels_per_m = 4;
  return quad;
}

Quad facing_south(const Eigen::Vector3d& foot, double width, double height, float gray) {
  return plain(wall(foot, {0, 0, -1}, width, height, {}), gray);
}

float brightness(float albedo) {  // what paint() makes of an unlit albedo
  Quad quad = facing_south({0, 0.5, 3}, 9, 9, albedo);
  const auto surfaces = paint({quad}, {});
  return Renderer(small_camera(), surfaces).render({}).gray.at<float>(60, 80);
}

// The middle of a small bright square, found by its brightness, is where the pose says, to a
// fraction of a pixel; and its area is right. Both depend on the edges' sampling.
TEST(Renderer, ASquareIsWherePoseAndCameraSay) {
  const Camera camera = small_camera();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const float black = brightness(0), white = brightness(200);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d centre(0.4 * uniform(random), 0.3 * uniform(random), 3 + uniform(random));
    const double size = 0.35;
    const auto surfaces =
        paint({facing_south({0, 50, 9}, 100, 100, 0),
               facing_south(centre + Eigen::Vector3d(0, size / 2, 0), size, size, 200)},
              {});
    Rigid3 pose;  // moved, not turned: the square stays a square
    pose.translation =
        Eigen::Vector3d(0.2 * uniform(random), 0.2 * uniform(random), 0.5 * uniform(random));
    const cv::Mat gray = Renderer(camera, surfaces).render(pose).gray;
    double sum = 0, x = 0, y = 0;
    for (int r = 0; r < gray.rows; ++r)
      for (int c = 0; c < gray.cols; ++c) {
        const double w = (gray.at<float>(r, c) - black) / (white - black);
        sum += w, x += w * c, y += w * r;
      }
    const Eigen::Vector3d in_camera = pose.inverse() * centre;
    const Eigen::Vector2d wanted =
        camera.pixel_from_normalized(in_camera.head<2>() / in_camera.z());
    EXPECT_NEAR(x / sum, wanted.x(), 0.08);
    EXPECT_NEAR(y / sum, wanted.y(), 0.08);
    const double scale = size / in_camera.z();
    EXPECT_NEAR(sum, scale * camera.fx * scale * camera.fy, 0.03 * sum);
  }
}

TEST(Renderer, NearHidesFarAndABackIsNotSeen) {
  const auto near = facing_south({0, 1, 2}, 2, 2, 60), far = facing_south({0, 1, 4}, 9, 9, 200);
  const auto back = plain(wall({0, 1, 1}, {0, 0, 1}, 5, 5, {}), 250);
  for (const auto& order : {std::vector{near, far, back}, std::vector{back, far, near}}) {
    const auto surfaces = paint(order, {});
    const auto rendering = Renderer(small_camera(), surfaces).render({});
    EXPECT_NEAR(rendering.gray.at<float>(60, 80), brightness(60), 0.5);
    EXPECT_NEAR(rendering.inverse_depth.at<float>(60, 80), 0.5, 1e-6);
  }
}

// The ground goes on below and behind the camera: what is cut at the near plane stays right.
TEST(Renderer, DepthOfTheGroundUnderATurnedCamera) {
  Quad ground;
  ground.origin = {-50, 0, 50};
  ground.u = {100, 0, 0};
  ground.v = {0, 0, -100};
  ground.texels_per_m = 1;
  const auto surfaces = paint({plain(ground, 100)}, {});
  const Camera camera = small_camera();
  const Rigid3 pose(so3_exp({-0.3, 0.4, 0.1}), {1, -1.5, 2});
  const auto rendering = Renderer(camera, surfaces).render(pose);
  int seen = 0;
  for (int r = 0; r < camera.height; ++r)
    for (int c = 0; c < camera.width; ++c) {
      const Eigen::Vector2d n = camera.normalized_from_pixel({c, r});
      const Eigen::Vector3d ray = pose.rotation * Eigen::Vector3d(n.x(), n.y(), 1);
      const double inverse_depth = ray.y() / 1.5;
      const Eigen::Vector3d x = pose.translation + ray / inverse_depth;
      const bool on_ground = inverse_depth > 0 && std::abs(x.x()) < 49 && std::abs(x.z()) < 49;
      if (on_ground) {
        EXPECT_NEAR(rendering.inverse_depth.at<float>(r, c), inverse_depth, 1e-5);
        ++seen;
      }
      if (ray.y() <= 0) {
        EXPECT_EQ(rendering.inverse_depth.at<float>(r, c), 0);
      }
    }
  EXPECT_GT(seen, 5000);
}

TEST(Renderer, ShadowFallsWhereTheSunIsHidden) {
  Quad ground;
  ground.origin = {-5, 0, 5};
  ground.u = {10, 0, 0};
  ground.v = {0, 0, -10};
  ground.painter = [](float, float) { return 0.5f; };
  ground.texels_per_m = 16;
  std::vector<Quad> quads{ground};
  add_box(quads, {{0, 0, 0}, 0, {1, 2, 1}, 16}, [&ground](int) { return ground.painter; });
  Sunlight light;
  light.towards_sun = {-1, -1, 0};  // from the west: the shadow lies 2 m to the east
  auto surfaces = paint(quads, light);
  const auto at = [&surfaces](double x, double z) {
    return surfaces[0].texture.sample(static_cast<float>(16 * (x + 5)),
                                      static_cast<float>(16 * (5 - z)), {0.1f, 0, 0, 0.1f});
  };
  EXPECT_LT(at(1.5, 0), 0.75 * at(-3.5, 0));
  EXPECT_LT(at(2.2, 0.2), 0.8 * at(-3.5, 0));
  EXPECT_NEAR(at(4, 0), at(-4, 0), 0.1 * at(-4, 0));
  EXPECT_LT(at(-0.6, 0), 0.97 * at(-4, 0));  // less sky beside the box, though in the sun
}

}  // namespace
}  // namespace eifmap::simulation
