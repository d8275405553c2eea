#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <stdexcept>

#include "features/matcher.h"

namespace eifmap {
namespace {

using Eigen::Vector2d;

std::vector<Vector2d> random_points(int count, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-size, size);
  std::vector<Vector2d> points;
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) points.emplace_back(place(random), place(random) / 3);
  return points;
}

std::vector<int> brute_force(const std::vector<Vector2d>& points, const Vector2d& x,
                             double radius) {
  std::vector<int> found;
  for (std::size_t i = 0; i < points.size(); ++i)
    if ((points[i] - x).squaredNorm() <= radius * radius) found.push_back(static_cast<int>(i));
  return found;
}

TEST(PointGrid, FindsWhatBruteForceFinds) {
  std::vector<int> found{99};
  for (const double cell : {0.001, 0.5, 7.0, 1000.0}) {
    const std::vector<Vector2d> points = random_points(300, 50, 1);
    const PointGrid grid(points, cell);
    for (const Vector2d& x : random_points(100, 70, 2))
      for (const double radius : {0.0, 1.0, 8.0, 60.0, 1e9}) {
        grid.near(x, radius, found);
        ASSERT_EQ(found, brute_force(points, x, radius)) << "cell " << cell << " radius " << radius;
      }
    grid.near(points[17], 0, found);
    EXPECT_EQ(found, std::vector<int>{17});
  }
}

TEST(PointGrid, PointsFarApartCostNoMemory) {
  const std::vector<Vector2d> points{{0, 0}, {1e15, -1e15}, {3, 4}};
  const PointGrid grid(points, 1);
  std::vector<int> found;
  grid.near({0, 0}, 5, found);
  EXPECT_EQ(found, (std::vector<int>{0, 2}));
}

TEST(PointGrid, NothingIsNearNothing) {
  std::vector<int> found{1, 2};
  PointGrid().near({0, 0}, 10, found);
  EXPECT_TRUE(found.empty());
  PointGrid(std::vector<Vector2d>{}, 1).near({0, 0}, 10, found);
  EXPECT_TRUE(found.empty());
  const PointGrid one(std::vector<Vector2d>{{1, 1}}, 1);
  one.near({1, 1}, -1, found);
  EXPECT_TRUE(found.empty());
  one.near({std::nan(""), 1}, 5, found);
  EXPECT_TRUE(found.empty());
}

TEST(PointGrid, RefusesBadCellsAndPoints) {
  const std::vector<Vector2d> points{{1, 1}};
  EXPECT_THROW(PointGrid(points, 0), std::invalid_argument);
  EXPECT_THROW(PointGrid(points, std::nan("")), std::invalid_argument);
  const std::vector<Vector2d> bad{{std::numeric_limits<double>::infinity(), 0}};
  EXPECT_THROW(PointGrid(bad, 1), std::invalid_argument);
}

}  // namespace
}  // namespace eifmap
