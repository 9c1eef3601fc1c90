// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace swiftlet {

/// A B for fixed sizes; each sum runs over the columns of A in their order. Eigen's lazyProduct begins its vectors at
/// an aligned address, so with an odd number of rows the order of its sums, and their last bits, depend on where the
/// compiler places the result.
template <int kRows, int kInner, class Right>
Eigen::Matrix<double, kRows, Right::ColsAtCompileTime> ordered_product(const Eigen::Matrix<double, kRows, kInner>& A,
                                                                       const Eigen::MatrixBase<Right>& B) {
  static_assert(Right::RowsAtCompileTime == kInner && Right::ColsAtCompileTime != Eigen::Dynamic);
  Eigen::Matrix<double, kRows, Right::ColsAtCompileTime> out;
  for (int j = 0; j < out.cols(); ++j) {
    Eigen::Matrix<double, kRows, 1> sum = A.col(0) * B(0, j);
    for (int k = 1; k < kInner; ++k) sum += A.col(k) * B(k, j);
    out.col(j) = sum;
  }
  return out;
}

/// A P A^T.
template <int kStates>
Eigen::Matrix<double, kStates, kStates> propagated(const Eigen::Matrix<double, kStates, kStates>& A,
                                                   const Eigen::Matrix<double, kStates, kStates>& P) {
  return ordered_product(ordered_product(A, P), A.transpose());
}

}  // namespace swiftlet
