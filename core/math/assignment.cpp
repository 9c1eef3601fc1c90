// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/math/assignment.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {

std::span<const int> Assignment::solve(std::span<const double> costs, int rows, int cols) {
  ENSURE(rows >= 0 && cols >= 0 && costs.size() == static_cast<std::size_t>(rows) * cols, costs.size(), rows, cols);
  pad(costs, rows, cols);
  // Columns are numbered from 1; column 0 holds the row to be assigned.
  potential_row_.assign(rows + 1, 0.0);
  potential_col_.assign(num_cols_ + 1, 0.0);
  row_of_col_.assign(num_cols_ + 1, 0);
  previous_col_.assign(num_cols_ + 1, 0);
  for (int row = 1; row <= rows; ++row) augment(row);

  result_.assign(rows, -1);
  for (int c = 1; c <= cols; ++c) {
    const int r = row_of_col_[c] - 1;
    if (r >= 0 && costs[r * cols + c - 1] < kForbidden) result_[r] = c - 1;
  }
  return result_;
}

/// Each row may stay unassigned, in a column of its own after the others: few rows and many columns stay cheap.
void Assignment::pad(std::span<const double> costs, int rows, int cols) {
  // A forbidden pair, or a row without a partner, costs more than all allowed pairs of an assignment together.
  double span = 0.0;
  for (const double c : costs) {
    if (c < kForbidden) span = std::max(span, std::abs(c));
  }
  const double dear = (span + 1.0) * 4.0 * (rows + 1);
  num_cols_ = cols + rows;
  padded_.assign(static_cast<std::size_t>(rows) * num_cols_, dear);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      padded_[static_cast<std::size_t>(r) * num_cols_ + c] = std::min(costs[r * cols + c], dear);
    }
  }
}

/// Assigns one more row: Dijkstra over columns until one is free.
void Assignment::augment(int row) {
  row_of_col_[0] = row;
  int here = 0;
  shortest_.assign(num_cols_ + 1, kForbidden);
  visited_.assign(num_cols_ + 1, 0);
  do {
    visited_[here] = 1;
    const int r = row_of_col_[here];
    double step = kForbidden;
    int next = 0;
    for (int c = 1; c <= num_cols_; ++c) {
      if (visited_[c]) continue;
      const double reduced =
          padded_[static_cast<std::size_t>(r - 1) * num_cols_ + c - 1] - potential_row_[r] - potential_col_[c];
      if (reduced < shortest_[c]) {
        shortest_[c] = reduced;
        previous_col_[c] = here;
      }
      if (shortest_[c] < step) {
        step = shortest_[c];
        next = c;
      }
    }
    for (int c = 0; c <= num_cols_; ++c) {
      if (visited_[c]) {
        potential_row_[row_of_col_[c]] += step;
        potential_col_[c] -= step;
      } else {
        shortest_[c] -= step;
      }
    }
    here = next;
  } while (row_of_col_[here] != 0);
  for (; here != 0; here = previous_col_[here]) row_of_col_[here] = row_of_col_[previous_col_[here]];
}

}  // namespace swiftlet
