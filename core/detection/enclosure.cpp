// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/enclosure.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace swiftlet {
namespace {

// True at the search limit, where a voxel counts as not enclosed.
bool at_border(const Cell& offset, const SearchShape& shape, double edge_m) {
  if (shape.octahedron) return offset.cwiseAbs().sum() >= shape.radius_steps - 1;
  return edge_m * edge_m * offset.squaredNorm() >= shape.radius_m * shape.radius_m;
}

bool is_above_view(const VoxelGrid& grid, const Cell& cell, const SearchShape& shape) {
  if (shape.top_z > 1.0) return false;
  const Vector3 from_sensor_m = grid.center_m(cell) - shape.sensor_m;
  return from_sensor_m.z() > shape.top_z * from_sensor_m.norm();
}

int half_width(const SearchShape& shape, double edge_m) {
  return shape.octahedron ? std::max(shape.radius_steps, 1) : static_cast<int>(std::ceil(shape.radius_m / edge_m)) + 1;
}

}  // namespace

bool EnclosureSearch::enclosed(const VoxelMap& map, std::span<const Cell> starts, const SearchShape& shape) {
  explored_.clear();
  parts_.clear();
  for (const Cell& start : starts) {
    if (is_known_enclosed(map, start, shape)) continue;
    if (leads_out(map, start, shape)) return false;
  }
  return true;
}

bool EnclosureSearch::is_known_enclosed(const VoxelMap& map, const Cell& start, const SearchShape& shape) const {
  const std::ptrdiff_t index = map.grid().contains(start) ? map.grid().index(start) : -1;
  return std::any_of(parts_.begin(), parts_.end(), [&](const Part& part) {
    if (!std::binary_search(explored_.begin() + part.first, explored_.begin() + part.last, index)) return false;
    const Cell farthest = (start - part.min).cwiseMax(part.max - start);
    return !at_border(farthest, shape, map.grid().edge_m);
  });
}

bool EnclosureSearch::leads_out(const VoxelMap& map, const Cell& start, const SearchShape& shape) {
  const VoxelGrid& grid = map.grid();
  if (!grid.contains(start)) return true;
  const int half = half_width(shape, grid.edge_m), width = 2 * half + 1;
  const std::size_t box = static_cast<std::size_t>(width) * width * width;
  if (seen_.size() < box) seen_.assign(box, flood_ = 0);
  ++flood_;
  const auto see = [&](const Cell& offset) {  // false: visited before
    const Cell at = offset.array() + half;
    std::uint32_t& mark = seen_[(static_cast<std::size_t>(at.z()) * width + at.y()) * width + at.x()];
    const bool is_new = mark != flood_;
    mark = flood_;
    return is_new;
  };
  static const std::array<Cell, 6> kSteps = {Cell(1, 0, 0),  Cell(-1, 0, 0), Cell(0, 1, 0),
                                             Cell(0, -1, 0), Cell(0, 0, -1), Cell(0, 0, 1)};

  Part part{explored_.size(), 0, start, start};
  stack_.assign(1, Cell::Zero());
  see(Cell::Zero());
  while (!stack_.empty()) {
    const Cell offset = stack_.back();
    stack_.pop_back();
    const Cell cell = start + offset;
    if (!grid.contains(cell)) return true;
    const std::ptrdiff_t index = grid.index(cell);
    const VoxelState state = map.state(index);
    if (state >= VoxelState::kTentative) return true;
    if (state == VoxelState::kFree || (offset != Cell::Zero() && is_above_view(grid, cell, shape))) continue;
    if (at_border(offset, shape, grid.edge_m)) return true;
    explored_.push_back(index);
    part.min = part.min.cwiseMin(cell);
    part.max = part.max.cwiseMax(cell);
    for (const Cell& step : kSteps) {
      if (see(offset + step)) stack_.push_back(offset + step);
    }
  }
  part.last = explored_.size();
  std::sort(explored_.begin() + part.first, explored_.begin() + part.last);
  if (part.last > part.first) parts_.push_back(part);
  return false;
}

}  // namespace swiftlet
