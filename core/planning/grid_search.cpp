// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/grid_search.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

#include "core/planning/polyline.hpp"

namespace swiftlet {
namespace {

struct Open {
  float cost;  // cost so far plus straight distance to the goal, in cells
  int index;
  // Ties in cost are broken by index, so that the path is deterministic.
  bool operator<(const Open& other) const { return cost != other.cost ? cost > other.cost : index > other.index; }
};

/// One search; start and goal count as free.
class GridSearch {
 public:
  GridSearch(const FreeSpaceView& space, int start, int goal)
      : space_(space),
        start_(start),
        goal_(goal),
        goal_m_(grid_.center_of(goal)),
        cost_(grid_.num_cells(), std::numeric_limits<float>::infinity()),
        parent_(grid_.num_cells(), -1) {}

  PathStatus run(std::size_t max_expansions) {
    cost_[static_cast<std::size_t>(start_)] = 0.0F;
    open_.push({rest(start_), start_});
    while (!open_.empty()) {
      const Open next = open_.top();
      open_.pop();
      if (next.index == goal_) return PathStatus::kFound;
      const float so_far = cost_[static_cast<std::size_t>(next.index)];
      if (next.cost > so_far + rest(next.index)) continue;  // a shorter path to the cell is known by now
      if (max_expansions-- == 0) return PathStatus::kBudgetSpent;
      expand(next.index, so_far);
    }
    return PathStatus::kNoPath;
  }

  std::vector<int> cells() const {
    std::vector<int> path;
    for (int i = goal_; i >= 0; i = i == start_ ? -1 : parent_[static_cast<std::size_t>(i)]) path.push_back(i);
    std::reverse(path.begin(), path.end());
    return path;
  }

 private:
  float rest(int index) const { return static_cast<float>((grid_.center_of(index) - goal_m_).norm() / grid_.cell_m); }

  void expand(int index, float so_far) {
    const Eigen::Vector3i cell = grid_.cell_of(index);
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const Eigen::Vector3i to = cell + Eigen::Vector3i(dx, dy, dz);
          const bool inside = (to.array() >= 0).all() && (to.array() < grid_.size.array()).all();
          if (!inside || to == cell) continue;
          reach(grid_.index_of(to), index, so_far + std::sqrt(static_cast<float>(dx * dx + dy * dy + dz * dz)));
        }
      }
    }
  }

  void reach(int index, int from, float cost) {
    if (cost >= cost_[static_cast<std::size_t>(index)]) return;
    if (index != goal_ && !space_.is_free_cell(index)) return;
    cost_[static_cast<std::size_t>(index)] = cost;
    parent_[static_cast<std::size_t>(index)] = from;
    open_.push({cost + rest(index), index});
  }

  const FreeSpaceView& space_;
  const CellGrid& grid_ = space_.grid();
  int start_, goal_;
  Vector3 goal_m_;
  std::vector<float> cost_;
  std::vector<int> parent_;
  std::priority_queue<Open> open_;
};

}  // namespace

PathResult find_path(const FreeSpaceView& space, const Vector3& start_world_m, const Vector3& goal_world_m,
                     std::size_t max_expansions) {
  if (!space.is_free(start_world_m)) return {PathStatus::kStartNotFree, {}};
  if (!space.is_free(goal_world_m)) return {PathStatus::kGoalNotFree, {}};
  const CellGrid& grid = space.grid();
  GridSearch search(space, grid.index_of(grid.cell_at(start_world_m)), grid.index_of(grid.cell_at(goal_world_m)));
  const PathStatus status = search.run(max_expansions);
  if (status != PathStatus::kFound) return {status, {}};
  const std::vector<int> cells = search.cells();
  std::vector<Vector3> path = {start_world_m};
  for (std::size_t i = 1; i + 1 < cells.size(); ++i) path.push_back(grid.center_of(cells[i]));
  path.push_back(goal_world_m);
  const auto is_free = [&space](const Vector3& a_world_m, const Vector3& b_world_m) {
    return is_free_segment(space, a_world_m, b_world_m);
  };
  return {PathStatus::kFound, cut_corners(path, is_free)};
}

}  // namespace swiftlet
