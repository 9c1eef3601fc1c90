// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <span>
#include <vector>

namespace swiftlet {

/// Which row goes to which column. As many as possible are paired, and among those pairings the sum of costs is the
/// least. The method is shortest augmenting paths (Jonker and Volgenant, Computing 38, 1987). Keeps its memory from
/// call to call.
class Assignment {
 public:
  static constexpr double kForbidden = std::numeric_limits<double>::infinity();

  /// @param costs  (rows x cols), row-major, finite or kForbidden
  /// @return for each row its column, or -1
  std::span<const int> solve(std::span<const double> costs, int rows, int cols);

 private:
  std::vector<double> padded_, potential_row_, potential_col_, shortest_;
  std::vector<int> row_of_col_, previous_col_, result_;
  std::vector<char> visited_;
};

}  // namespace swiftlet
