// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Solves H x = b for a sparse, symmetric, positive definite H of 6 x 6 blocks, by the factorization H = L D L^T of T.
/// Davis, "Algorithm 849: a concise sparse Cholesky factorization package", ACM TOMS 2005, here on blocks instead of
/// scalars. Blocks are eliminated in approximate minimum degree order, which keeps L sparse. A single thread sums in a
/// fixed order, so that results are bit-identical on all machines.
class BlockCholesky {
 public:
  BlockCholesky() = default;
  BlockCholesky(int num_blocks, std::span<const std::pair<int, int>> pairs) {
    set_pattern(num_blocks, pairs);
    set_zero();
  }
  /// Sets which blocks of H may be nonzero: the diagonal ones, and those at `pairs` of different indices, in any order,
  /// duplicates allowed. Reuses memory. Call set_zero() before adding values.
  void set_pattern(int num_blocks, std::span<const std::pair<int, int>> pairs);

  int num_blocks() const { return static_cast<int>(diagonal_.size()); }
  /// Sets all blocks of H to zero.
  void set_zero();
  /// Block (i, i).
  Matrix6& diagonal(int i) { return diagonal_[place_[i]]; }
  const Matrix6& diagonal(int i) const { return diagonal_[place_[i]]; }
  /// Adds a block at (i, j), and its transpose at (j, i).
  /// @param pair  index of (i, j) in the pairs of the pattern
  void add(std::size_t pair, const Matrix6& block);
  /// Factorizes H + damping diag(H). False when this matrix is not positive definite.
  bool factorize(double damping);
  /// Solves for x with the last factorization.
  void solve(std::span<const Vector6> b, std::vector<Vector6>& x);

 private:
  // All blocks are stored in elimination order, in which block i is at place_[i].
  std::vector<int> place_;
  std::vector<Matrix6> diagonal_;
  // Blocks of H above the diagonal, in compressed columns: index of the first block of each column, then row and value
  // of each block, rows ascending.
  std::vector<int> first_, row_;
  std::vector<Matrix6> value_;
  // Where the block of a pair (i, j) is stored.
  struct Slot {
    int value = 0;        // index in value_
    bool turned = false;  // stored as (j, i), because j is eliminated before i
  };
  std::vector<Slot> slots_;  // indexed by pair
  // L in compressed columns: parents in the elimination tree, first block, number of blocks, and row of each block.
  std::vector<int> parent_, first_of_L_, num_in_L_, row_of_L_;
  std::vector<Matrix6> L_, D_inverse_;
  // Working memory of the factorization.
  std::vector<Matrix6> column_;
  std::vector<int> flag_, pattern_, path_;
  std::vector<Vector6> ordered_;  // b, then x, in the order of elimination
};

/// Working memory of an optimization, kept between calls: its allocation would take a tenth of the time at 10 000
/// nodes.
struct GraphWorkspace {
  BlockCholesky H;
  std::vector<Vector6> gradient, step;
  // Residuals of the relative factors, at the current poses and at the trial poses of the step.
  std::vector<Vector6> of_relatives, of_relatives_tried;
  std::vector<Pose> tried;
};

}  // namespace swiftlet
