#include "filter/latest_poses.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace eifmap {

bool solve_latest(const BlockMatrix& matrix, const Eigen::VectorXd& right_side, int count,
                  int standing, Eigen::VectorXd& x) {
  int first = std::max(0, matrix.size() - count);
  if (standing >= first && first > 0) --first;
  const bool one_stands = standing >= first;
  const Eigen::Index size = kPoseDof * (matrix.size() - first - static_cast<int>(one_stands));
  const auto place = [&](int block) {
    return kPoseDof * (block - first - static_cast<int>(one_stands && block > standing));
  };
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd right(size);
  for (int a = first; a < matrix.size(); ++a) {
    if (a == standing) continue;
    const BlockColumn& column = matrix.column(a);
    for (std::size_t k = 0; k < column.row.size(); ++k)
      if (column.row[k] >= first && column.row[k] != standing)
        lower.block<kPoseDof, kPoseDof>(place(a), place(column.row[k])) =
            column.block[k].transpose();
    right.segment<kPoseDof>(place(a)) = right_side.segment<kPoseDof>(kPoseDof * a);
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(lower);
  if (llt.info() != Eigen::Success) return false;
  llt.solveInPlace(right);
  x = Eigen::VectorXd::Zero(right_side.size());
  for (int a = first; a < matrix.size(); ++a)
    if (a != standing) x.segment<kPoseDof>(kPoseDof * a) = right.segment<kPoseDof>(place(a));
  return right.allFinite();
}

}  // namespace eifmap
