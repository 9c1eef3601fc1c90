// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/block_cholesky.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

/// Elimination order: place[i] is the position of block i.
std::vector<int> minimum_degree(int num_blocks, std::span<const std::pair<int, int>> pairs) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(2 * pairs.size() + num_blocks);
  for (int i = 0; i < num_blocks; ++i) entries.emplace_back(i, i, 1.0);
  for (const auto& [i, j] : pairs) {
    entries.emplace_back(i, j, 1.0);
    entries.emplace_back(j, i, 1.0);
  }
  Eigen::SparseMatrix<double> pattern(num_blocks, num_blocks);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern, order);
  std::vector<int> place(num_blocks);
  for (int k = 0; k < num_blocks; ++k) place[order.indices()[k]] = k;
  return place;
}

/// Inverse of a symmetric, positive definite A by its Cholesky factor; false when A is not positive definite. Eigen's
/// solvers take three times as long for so small a block.
bool invert_block(const Matrix6& A, Matrix6& inverse) {
  double C[6][6];  // A = C C^T, with inverse diagonal
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < i; ++j) {
      double sum = A(i, j);
      for (int k = 0; k < j; ++k) sum -= C[i][k] * C[j][k];
      C[i][j] = sum * C[j][j];
    }
    double sum = A(i, i);
    for (int k = 0; k < i; ++k) sum -= C[i][k] * C[i][k];
    if (!(sum > 0.0)) return false;
    C[i][i] = 1.0 / std::sqrt(sum);
  }
  double F[6][6];  // C^-1
  for (int j = 0; j < 6; ++j) {
    F[j][j] = C[j][j];
    for (int i = j + 1; i < 6; ++i) {
      double sum = 0.0;
      for (int k = j; k < i; ++k) sum -= C[i][k] * F[k][j];
      F[i][j] = sum * C[i][i];
    }
  }
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = 0.0;
      for (int k = i; k < 6; ++k) sum += F[k][i] * F[k][j];
      inverse(i, j) = inverse(j, i) = sum;
    }
  }
  return true;
}

}  // namespace

void BlockCholesky::set_pattern(int num_blocks, std::span<const std::pair<int, int>> pairs) {
  place_ = minimum_degree(num_blocks, pairs);
  diagonal_.resize(num_blocks);
  std::vector<std::pair<int, int>> above;  // column, row
  above.reserve(pairs.size());
  for (const auto& [i, j] : pairs) {
    ENSURE(i != j && i >= 0 && j >= 0 && i < num_blocks && j < num_blocks, i, j, num_blocks);
    above.emplace_back(std::max(place_[i], place_[j]), std::min(place_[i], place_[j]));
  }
  std::sort(above.begin(), above.end());
  above.erase(std::unique(above.begin(), above.end()), above.end());
  first_.assign(num_blocks + 1, 0);
  row_.clear();
  row_.reserve(above.size());
  for (const auto& [column, row] : above) {
    ++first_[column + 1];
    row_.push_back(row);
  }
  for (int k = 0; k < num_blocks; ++k) first_[k + 1] += first_[k];
  value_.resize(row_.size());
  slots_.clear();
  slots_.reserve(pairs.size());
  for (const auto& [i, j] : pairs) {
    const int column = std::max(place_[i], place_[j]), row = std::min(place_[i], place_[j]);
    const auto found = std::lower_bound(row_.begin() + first_[column], row_.begin() + first_[column + 1], row);
    slots_.push_back({static_cast<int>(found - row_.begin()), place_[i] > place_[j]});
  }

  // Elimination tree, and the number of blocks in each column of L.
  parent_.assign(num_blocks, -1);
  num_in_L_.assign(num_blocks, 0);
  flag_.assign(num_blocks, -1);
  for (int k = 0; k < num_blocks; ++k) {
    flag_[k] = k;
    for (int p = first_[k]; p < first_[k + 1]; ++p) {
      for (int i = row_[p]; flag_[i] != k; i = parent_[i]) {
        if (parent_[i] == -1) parent_[i] = k;
        ++num_in_L_[i];
        flag_[i] = k;
      }
    }
  }
  first_of_L_.assign(num_blocks + 1, 0);
  for (int k = 0; k < num_blocks; ++k) first_of_L_[k + 1] = first_of_L_[k] + num_in_L_[k];
  row_of_L_.resize(first_of_L_.back());
  L_.resize(first_of_L_.back());
  D_inverse_.resize(num_blocks);
  column_.assign(num_blocks, Matrix6::Zero());
  pattern_.resize(num_blocks);
  path_.resize(num_blocks);
}

void BlockCholesky::set_zero() {
  std::fill(diagonal_.begin(), diagonal_.end(), Matrix6::Zero());
  std::fill(value_.begin(), value_.end(), Matrix6::Zero());
}

void BlockCholesky::add(std::size_t pair, const Matrix6& block) {
  ENSURE(pair < slots_.size(), pair, slots_.size());
  const Slot& slot = slots_[pair];
  if (slot.turned)
    value_[slot.value] += block.transpose();
  else
    value_[slot.value] += block;
}

bool BlockCholesky::factorize(double damping) {
  const int n = num_blocks();
  std::fill(num_in_L_.begin(), num_in_L_.end(), 0);
  std::fill(flag_.begin(), flag_.end(), -1);
  for (int k = 0; k < n; ++k) {
    // Column k of H, and the rows reached from it through the tree, children before parents.
    int top = n;
    flag_[k] = k;
    for (int p = first_[k]; p < first_[k + 1]; ++p) {
      column_[row_[p]] = value_[p];
      int length = 0;
      for (int i = row_[p]; flag_[i] != k; i = parent_[i]) {
        path_[length++] = i;
        flag_[i] = k;
      }
      while (length > 0) pattern_[--top] = path_[--length];
    }
    Matrix6 D = diagonal_[k];
    D.diagonal() *= 1.0 + damping;
    for (; top < n; ++top) {
      const int i = pattern_[top];
      const Matrix6 y = column_[i];
      column_[i].setZero();
      const int end = first_of_L_[i] + num_in_L_[i];
      for (int p = first_of_L_[i]; p < end; ++p) column_[row_of_L_[p]].noalias() -= L_[p] * y;
      L_[end].noalias() = y.transpose() * D_inverse_[i];
      D.noalias() -= L_[end] * y;
      row_of_L_[end] = k;
      ++num_in_L_[i];
    }
    if (!invert_block(D, D_inverse_[k])) {
      std::fill(column_.begin(), column_.end(), Matrix6::Zero());
      return false;
    }
  }
  return true;
}

void BlockCholesky::solve(std::span<const Vector6> b, std::vector<Vector6>& x) {
  const int n = num_blocks();
  ENSURE(static_cast<int>(b.size()) == n, b.size(), n);
  std::vector<Vector6>& y = ordered_;
  y.resize(n);
  for (int i = 0; i < n; ++i) y[place_[i]] = b[i];
  for (int k = 0; k < n; ++k) {
    for (int p = first_of_L_[k]; p < first_of_L_[k + 1]; ++p) y[row_of_L_[p]].noalias() -= L_[p] * y[k];
  }
  for (int k = n - 1; k >= 0; --k) {
    y[k] = (D_inverse_[k] * y[k]).eval();
    for (int p = first_of_L_[k]; p < first_of_L_[k + 1]; ++p) y[k].noalias() -= L_[p].transpose() * y[row_of_L_[p]];
  }
  x.resize(n);
  for (int i = 0; i < n; ++i) x[i] = y[place_[i]];
}

}  // namespace swiftlet
