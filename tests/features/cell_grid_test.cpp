#include "features/cell_grid.h"

#include <gtest/gtest.h>

#include "features/images.h"

namespace eifmap {
namespace {

// Mean over [x0, x0 + side) x [y0, y0 + side), pixel p covering [p - .5, p + .5) and the outermost
// ones all that lies outside.
double brute_force_mean(const cv::Mat& image, double x0, double y0, double side) {
  const auto overlap = [](double begin, double end, int pixel) {
    return std::max(0.0, std::min(end, pixel + 0.5) - std::max(begin, pixel - 0.5));
  };
  double sum = 0;
  for (int y = static_cast<int>(std::floor(y0)) - 1; y <= y0 + side + 1; ++y)
    for (int x = static_cast<int>(std::floor(x0)) - 1; x <= x0 + side + 1; ++x)
      sum += overlap(x0, x0 + side, x) * overlap(y0, y0 + side, y) *
             image.at<std::uint8_t>(std::clamp(y, 0, image.rows - 1),
                                    std::clamp(x, 0, image.cols - 1));
  return sum / (side * side);
}

void expect_grid(const cv::Mat& image, float u, float v, float side) {
  CellGrid grid;
  grid.sample(IntegralImage(image), u, v, side);
  const auto expected = [&](int i, int j) {
    const double half = 0.5 * CellGrid::kCells * side;
    return brute_force_mean(image, u - half + i * side, v - half + j * side, side);
  };
  const double level = grid.mean[0][0] - expected(0, 0);
  for (int j = 0; j < CellGrid::kCells; ++j)
    for (int i = 0; i < CellGrid::kCells; ++i)
      ASSERT_NEAR(grid.mean[j][i] - level, expected(i, j), 0.02)
          << "cell " << i << ' ' << j << " of " << u << ' ' << v << ' ' << side;
}

TEST(CellGrid, CellsAreExactMeans) {
  const cv::Mat image = testing::random_image(160, 140, 1);
  expect_grid(image, 80, 70, 1);
  expect_grid(image, 81.37f, 69.81f, 1.213f);
  expect_grid(image, 77.52f, 71.08f, 0.61f);
  expect_grid(image, 79.9f, 70.3f, 5.7f);
}

TEST(CellGrid, TheBorderGoesOnOutside) {
  const cv::Mat image = testing::random_image(60, 50, 2);
  expect_grid(image, 3.3f, 2.2f, 1.7f);
  expect_grid(image, 58.1f, 47.6f, 2.4f);
  expect_grid(image, 0, 0, 4.1f);
}

void expect_turned_grid(const cv::Mat& image, float u, float v, float side, float angle) {
  CellGrid grid;
  grid.sample_turned(IntegralImage(image), u, v, side, angle);
  constexpr int kMiddle = CellGrid::kCells / 2;
  const Eigen::Rotation2Dd turn(angle);
  for (int j = 0; j < CellGrid::kCells; ++j)
    for (int i = 0; i < CellGrid::kCells; ++i) {
      const Eigen::Vector2d corner = Eigen::Vector2d(u, v) +
                                     side * (turn * Eigen::Vector2d(i - kMiddle, j - kMiddle)) -
                                     0.5 * side * Eigen::Vector2d::Ones();
      ASSERT_NEAR(grid.mean[j][i], brute_force_mean(image, corner.x(), corner.y(), side), 0.02)
          << "cell " << i << ' ' << j << " of " << u << ' ' << v << ' ' << side << ' ' << angle;
    }
}

TEST(CellGrid, TurnedCellsAreExactMeansAtTurnedPlaces) {
  const cv::Mat image = testing::random_image(160, 140, 3);
  for (const float angle : {0.3f, 1.5f, -0.8f, 3.0f, -2.6f}) {
    expect_turned_grid(image, 80, 70, 1, angle);
    expect_turned_grid(image, 81.37f, 69.81f, 1.213f, angle);
    expect_turned_grid(image, 77.52f, 71.08f, 0.61f, angle);
    expect_turned_grid(image, 79.9f, 70.3f, 5.7f, angle);
    expect_turned_grid(image, 2.3f, 137.2f, 2.4f, angle);
    expect_turned_grid(image, 159, 0, 9.1f, angle);
  }
}

}  // namespace
}  // namespace eifmap
