// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <span>
#include <vector>

namespace swiftlet {

/// Assignment of rows to columns: the maximum number of pairs, and among those the smallest sum of costs. Shortest
/// augmenting paths (Jonker and Volgenant, Computing 38, 1987). Reuses its memory from call to call.
class Assignment {
 public:
  /// Cost of a pair that must not be assigned.
  static constexpr double kForbidden = std::numeric_limits<double>::infinity();

  /// @param costs  (rows x cols), row-major, finite or kForbidden
  /// @return column of each row, or -1
  std::span<const int> solve(std::span<const double> costs, int rows, int cols);

 private:
  void pad(std::span<const double> costs, int rows, int cols);
  void augment(int row);

  int num_cols_ = 0;  // columns of the padded costs
  std::vector<double> padded_, potential_row_, potential_col_, shortest_;
  std::vector<int> row_of_col_, previous_col_, result_;
  std::vector<char> visited_;
};

}  // namespace swiftlet
