// The oracle for every analytic Jacobian: central differences.
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace eifmap::test {

// d f / d delta at delta = 0, where `f` maps a Vector<double, N> displacement (on a manifold: the
// argument of its retraction) to a Vector<double, M>. Error about step^2.
template <int M, int N, typename Function>
Eigen::Matrix<double, M, N> numeric_jacobian(const Function& f, double step = 1e-6) {
  Eigen::Matrix<double, M, N> jacobian;
  for (int c = 0; c < N; ++c) {
    const Eigen::Matrix<double, N, 1> delta = step * Eigen::Matrix<double, N, 1>::Unit(c);
    const Eigen::Matrix<double, M, 1> up = f(delta), down = f(-delta);
    jacobian.col(c) = (up - down) / (2 * step);
  }
  return jacobian;
}

// Largest entry of the difference, relative to the largest entry of the numeric one.
template <typename A, typename B>
double relative_difference(const Eigen::MatrixBase<A>& analytic,
                           const Eigen::MatrixBase<B>& numeric) {
  const double size = std::max(1e-12, numeric.cwiseAbs().maxCoeff());
  return (analytic - numeric).cwiseAbs().maxCoeff() / size;
}

}  // namespace eifmap::test
