#include "filter/latest_poses.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace eifmap {

bool solve_latest(const BlockMatrix& matrix, const Eigen::VectorXd& right_side, int count,
                  Eigen::VectorXd& x) {
  const int first = std::max(0, matrix.size() - count);
  const Eigen::Index size = kPoseDof * (matrix.size() - first);
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(size, size);
  for (int a = first; a < matrix.size(); ++a) {
    const BlockColumn& column = matrix.column[a];
    for (std::size_t k = 0; k < column.row.size(); ++k)
      if (column.row[k] >= first)
        lower.block<kPoseDof, kPoseDof>(kPoseDof * (a - first),
                                        kPoseDof * (column.row[k] - first)) =
            column.block[k].transpose();
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(lower);
  if (llt.info() != Eigen::Success) return false;
  x = Eigen::VectorXd::Zero(right_side.size());
  x.tail(size) = llt.solve(right_side.tail(size));
  return x.allFinite();
}

}  // namespace eifmap
