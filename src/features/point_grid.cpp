#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "features/matcher.h"

namespace eifmap {
namespace {

// Sparse points spread over a huge area get larger buckets instead of billions of empty ones.
constexpr double kMaxBucketsPerPoint = 16;

}  // namespace

PointGrid::PointGrid(std::span<const Eigen::Vector2d> points, double cell)
    : points_(points.begin(), points.end()), cell_(cell) {
  if (!(cell > 0) || !std::isfinite(cell))
    throw std::invalid_argument("PointGrid: the cell's side must be positive");
  for (const Eigen::Vector2d& p : points_)
    if (!p.allFinite()) throw std::invalid_argument("PointGrid: a point is not finite");
  if (points_.empty()) return;

  origin_ = points_.front();
  Eigen::Vector2d top = origin_;
  for (const Eigen::Vector2d& p : points_) {
    origin_ = origin_.cwiseMin(p);
    top = top.cwiseMax(p);
  }
  const double most = kMaxBucketsPerPoint * static_cast<double>(points_.size()) + 1024;
  const Eigen::Vector2d extent = top - origin_;
  while ((std::floor(extent.x() / cell_) + 1) * (std::floor(extent.y() / cell_) + 1) > most)
    cell_ *= 2;
  columns_ = static_cast<int>(extent.x() / cell_) + 1;
  rows_ = static_cast<int>(extent.y() / cell_) + 1;

  const auto bucket = [this](const Eigen::Vector2d& p) {
    const Eigen::Vector2d q = (p - origin_) / cell_;
    return static_cast<std::size_t>(q.y()) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(q.x());
  };
  start_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (const Eigen::Vector2d& p : points_) ++start_[bucket(p) + 1];
  for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
  order_.resize(points_.size());
  std::vector<int> next(start_.begin(), start_.end() - 1);
  for (std::size_t i = 0; i < points_.size(); ++i)
    order_[static_cast<std::size_t>(next[bucket(points_[i])]++)] = static_cast<int>(i);
}

void PointGrid::near(const Eigen::Vector2d& x, double radius, std::vector<int>& found) const {
  found.clear();
  if (points_.empty() || !x.allFinite() || !(radius >= 0)) return;
  const auto column_or_row = [this](double distance, int count) {
    return static_cast<int>(std::clamp(std::floor(distance / cell_), -1.0, double(count)));
  };
  const Eigen::Vector2d d = x - origin_;
  const int first_column = std::max(0, column_or_row(d.x() - radius, columns_));
  const int last_column = std::min(columns_ - 1, column_or_row(d.x() + radius, columns_));
  const int first_row = std::max(0, column_or_row(d.y() - radius, rows_));
  const int last_row = std::min(rows_ - 1, column_or_row(d.y() + radius, rows_));
  for (int row = first_row; row <= last_row; ++row)
    for (int column = first_column; column <= last_column; ++column) {
      const std::size_t c = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                            static_cast<std::size_t>(column);
      for (int k = start_[c]; k < start_[c + 1]; ++k) {
        const int i = order_[static_cast<std::size_t>(k)];
        if ((points_[static_cast<std::size_t>(i)] - x).squaredNorm() <= radius * radius)
          found.push_back(i);
      }
    }
  std::sort(found.begin(), found.end());
}

}  // namespace eifmap
