#include "client/demo/top_view.h"

#include <gtest/gtest.h>

#include <numbers>

#include "client/demo/canvas.h"

namespace eifmap {
namespace {

TEST(Canvas, DrawsWhereAndAsLargeAsAsked) {
  Canvas canvas(100, 60, {0, 0, 0});
  canvas.disc({40, 20}, 10, {200, 100, 50});
  const cv::Mat image = canvas.finished();
  ASSERT_EQ(image.size(), cv::Size(100, 60));
  double sum = 0, x = 0, y = 0;
  for (int r = 0; r < image.rows; ++r)
    for (int c = 0; c < image.cols; ++c) {
      const double w = image.at<cv::Vec3b>(r, c)[2] / 200.0;  // red, of blue green red
      sum += w, x += w * c, y += w * r;
    }
  EXPECT_NEAR(x / sum, 40, 0.3);
  EXPECT_NEAR(y / sum, 20, 0.3);
  EXPECT_NEAR(sum, std::numbers::pi * 100, 25);
}

TEST(Canvas, FlattenLetsTheGroundShine) {
  Canvas canvas(20, 20, {0, 0, 0});
  canvas.disc({10, 10}, 5, {200, 200, 200});
  canvas.flatten(0.5);
  EXPECT_NEAR(canvas.finished().at<cv::Vec3b>(10, 10)[0], 100, 1);
}

// Where the picture, below its header, has about this colour.
std::vector<Eigen::Vector2d> pixels_like(const cv::Mat& image, const Colour& colour) {
  std::vector<Eigen::Vector2d> pixels;
  for (int y = 200; y < image.rows - 110; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const auto& p = image.at<cv::Vec3b>(y, x);
      if (std::abs(p[2] - colour.red) + std::abs(p[1] - colour.green) +
              std::abs(p[0] - colour.blue) <
          40)
        pixels.emplace_back(x, y);
    }
  return pixels;
}

Eigen::Vector2d mean(const std::vector<Eigen::Vector2d>& pixels) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& pixel : pixels) sum += pixel;
  return sum / std::max<double>(1, static_cast<double>(pixels.size()));
}

// A straight walk with a tall pole on its left: in the picture, too, the pole is on the left of the
// path, wherever the world's axes point.
TEST(TopView, LeftIsLeftInAnyWorld) {
  for (const Eigen::Vector3d& turn : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1.2, -0.4, 2)}) {
    const Rigid3 world(so3_exp(turn), {3, -2, 1});
    TopViewData data;
    for (int i = 0; i <= 40; ++i)
      data.path.push_back({0.1 * i, world * Rigid3({1, 0, 0, 0}, {0, 0, 0.1 * i})});
    for (int i = 0; i < 400; ++i)
      data.points.push_back(
          {world * Eigen::Vector3d(-1 + 0.03 * std::cos(i), -0.01 * i, 2 + 0.03 * std::sin(i)), 1,
           3});
    const cv::Mat image = draw_top_view(data);
    const auto path = pixels_like(image, {255, 140, 66});
    const auto pole = pixels_like(image, blend({15, 19, 28}, height_colour(1), 0.85));
    ASSERT_GT(path.size(), 1000u);
    ASSERT_GT(pole.size(), 100u);
    // The path lies across the picture, and a disc marks its start: more pixels at that end.
    const auto before = [](double x) {
      return [x](const Eigen::Vector2d& p) { return p.x() < x; };
    };
    const auto by_x = [](const auto& a, const auto& b) { return a.x() < b.x(); };
    const double left = std::min_element(path.begin(), path.end(), by_x)->x();
    const double right = std::max_element(path.begin(), path.end(), by_x)->x();
    const auto at_left = std::count_if(path.begin(), path.end(), before(left + 12));
    const auto up_to_right = std::count_if(path.begin(), path.end(), before(right - 12));
    const bool rightwards = at_left > static_cast<std::ptrdiff_t>(path.size()) - up_to_right;
    const double pole_below = mean(pole).y() - mean(path).y();
    EXPECT_LT(rightwards ? pole_below : -pole_below, -100);
    EXPECT_NEAR(mean(pole).x(), 0.5 * (left + right), 30);  // beside its middle
  }
}

TEST(TopView, DrawsWithoutTruthPointsOrPath) {
  TopViewData data;
  data.title = "nothing";
  EXPECT_FALSE(draw_top_view(data).empty());
  data.path.push_back({0, Rigid3()});
  data.keyframes = data.path;
  EXPECT_FALSE(draw_top_view(data).empty());
  data.points.push_back({{1, 2, 3}, 1, 3});
  EXPECT_FALSE(draw_top_view(data).empty());
}

}  // namespace
}  // namespace eifmap
