// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "swiftlet/core/planning/grid_search.hpp"

namespace swiftlet::testing {

/// A box of 20 m x 20 m in which everything is free but what a predicate takes away.
class BoxSpace : public FreeSpaceView {
 public:
  /// @param layers  of cells, one above the other
  explicit BoxSpace(std::function<bool(const Vector3&)> occupied, int layers = 8) : occupied_(std::move(occupied)) {
    grid_.origin_world_m = {-10, -10, 0};
    grid_.cell_m = 0.5;
    grid_.size = {40, 40, layers};
  }
  const CellGrid& grid() const override { return grid_; }
  bool is_free(const Vector3& p) const override { return !occupied_(p); }
  bool is_free_cell(int index) const override { return is_free(grid_.center_of(index)); }

 private:
  std::function<bool(const Vector3&)> occupied_;
  CellGrid grid_;
};

inline double length_m(const std::vector<Vector3>& path) {
  double sum_m = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum_m += (path[i] - path[i - 1]).norm();
  return sum_m;
}

}  // namespace swiftlet::testing
