// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/slam/block_cholesky.hpp"

#include <Eigen/Cholesky>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>

#include "swiftlet/core/ensure.hpp"

namespace swiftlet {
namespace {

/// place[i]: when block i is eliminated.
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

}  // namespace

BlockCholesky::BlockCholesky(int num_blocks, std::span<const std::pair<int, int>> pairs)
    : place_(minimum_degree(num_blocks, pairs)), diagonal_(num_blocks) {
  std::vector<std::pair<int, int>> above;  // column, row
  above.reserve(pairs.size());
  for (const auto& [i, j] : pairs) {
    ENSURE(i != j && i >= 0 && j >= 0 && i < num_blocks && j < num_blocks, i, j, num_blocks);
    above.emplace_back(std::max(place_[i], place_[j]), std::min(place_[i], place_[j]));
  }
  std::sort(above.begin(), above.end());
  above.erase(std::unique(above.begin(), above.end()), above.end());
  first_.assign(num_blocks + 1, 0);
  row_.reserve(above.size());
  for (const auto& [column, row] : above) {
    ++first_[column + 1];
    row_.push_back(row);
  }
  for (int k = 0; k < num_blocks; ++k) first_[k + 1] += first_[k];
  value_.resize(row_.size());

  // The elimination tree, and how many blocks each column of L has.
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
  set_zero();
}

void BlockCholesky::set_zero() {
  std::fill(diagonal_.begin(), diagonal_.end(), Matrix6::Zero());
  std::fill(value_.begin(), value_.end(), Matrix6::Zero());
}

void BlockCholesky::add(int i, int j, const Matrix6& block) {
  const int a = place_[i], b = place_[j];
  const int column = std::max(a, b), row = std::min(a, b);
  const auto begin = row_.begin() + first_[column], end = row_.begin() + first_[column + 1];
  const auto found = std::lower_bound(begin, end, row);
  ENSURE(found != end && *found == row, i, j);
  Matrix6& value = value_[found - row_.begin()];
  if (a < b)
    value += block;
  else
    value += block.transpose();
}

bool BlockCholesky::factorize(double damping) {
  const int n = num_blocks();
  std::fill(num_in_L_.begin(), num_in_L_.end(), 0);
  std::fill(flag_.begin(), flag_.end(), -1);
  for (int k = 0; k < n; ++k) {
    // Column k of H, and the rows that it reaches through the tree, children before parents.
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
    const Eigen::LLT<Matrix6> cholesky(D);
    if (cholesky.info() != Eigen::Success) {
      std::fill(column_.begin(), column_.end(), Matrix6::Zero());
      return false;
    }
    D_inverse_[k] = cholesky.solve(Matrix6::Identity());
  }
  return true;
}

bool BlockCholesky::solve(double damping, std::span<const Vector6> b, std::vector<Vector6>& x) {
  const int n = num_blocks();
  ENSURE(static_cast<int>(b.size()) == n, b.size(), n);
  if (!factorize(damping)) return false;
  std::vector<Vector6> y(n);
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
  return true;
}

}  // namespace swiftlet
