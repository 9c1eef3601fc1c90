// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <utility>

namespace swiftlet {

/// Eigenvalues in ascending order and unit eigenvectors (columns) of a symmetric matrix.
template <int N>
struct SymmetricEigen {
  Eigen::Matrix<double, N, 1> values;
  Eigen::Matrix<double, N, N> vectors;
};

/// Jacobi rotations in a fixed order (Golub and Van Loan, Matrix Computations, sec. 8.5), for small N. Arithmetic and
/// square roots only, so results are bit-identical on all machines if the compiler contracts no multiply-adds
/// (-ffp-contract=off).
template <int N>
SymmetricEigen<N> symmetric_eigen(Eigen::Matrix<double, N, N> A) {
  // [-] Limit of sweeps over all pairs. Small matrices converge within six; the limit ends the loop for matrices with
  // NaN or infinity.
  constexpr int kMaxSweeps = 16;
  SymmetricEigen<N> out;
  out.vectors.setIdentity();
  const double scale = A.cwiseAbs().maxCoeff();
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    double off = 0.0;
    for (int p = 0; p < N; ++p)
      for (int q = p + 1; q < N; ++q) off += std::abs(A(p, q));
    if (off <= 1e-15 * scale) break;
    for (int p = 0; p < N; ++p) {
      for (int q = p + 1; q < N; ++q) {
        if (A(p, q) == 0.0) continue;
        const double half = (A(q, q) - A(p, p)) / (2.0 * A(p, q));
        const double t = (half >= 0.0 ? 1.0 : -1.0) / (std::abs(half) + std::sqrt(1.0 + half * half));
        const double c = 1.0 / std::sqrt(1.0 + t * t), s = t * c;
        for (int k = 0; k < N; ++k) {
          const double a = A(k, p), b = A(k, q);
          A(k, p) = c * a - s * b;
          A(k, q) = s * a + c * b;
        }
        for (int k = 0; k < N; ++k) {
          const double a = A(p, k), b = A(q, k);
          A(p, k) = c * a - s * b;
          A(q, k) = s * a + c * b;
        }
        for (int k = 0; k < N; ++k) {
          const double a = out.vectors(k, p), b = out.vectors(k, q);
          out.vectors(k, p) = c * a - s * b;
          out.vectors(k, q) = s * a + c * b;
        }
      }
    }
  }
  out.values = A.diagonal();
  for (int i = 0; i < N; ++i) {  // selection sort; N is small
    int least = i;
    for (int j = i + 1; j < N; ++j)
      if (out.values(j) < out.values(least)) least = j;
    if (least == i) continue;
    std::swap(out.values(i), out.values(least));
    out.vectors.col(i).swap(out.vectors.col(least));
  }
  return out;
}

}  // namespace swiftlet
