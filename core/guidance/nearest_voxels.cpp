// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/nearest_voxels.hpp"

#include <algorithm>
#include <limits>

namespace swiftlet {
namespace {

constexpr float kAlways = -std::numeric_limits<float>::infinity();

constexpr std::array<float, 1024> kHalfReciprocal = [] {
  std::array<float, 1024> table{};
  for (int n = 1; n < 1024; ++n) table[static_cast<std::size_t>(n)] = 0.5F / static_cast<float>(n);
  return table;
}();

float squared(int n) { return static_cast<float>(n * n); }

}  // namespace

// Extends the lower envelope of parabolas (s - q)^2 + height, with increasing q.
void NearestVoxels::Line::add(int q, float height_sq, std::int32_t whose) {
  const float value = height_sq + squared(q);
  float start = kAlways;
  while (count > 0) {
    const int v = at[count - 1];
    start = (value - height[count - 1] - squared(v)) * kHalfReciprocal[q - v];
    if (start > from[count - 1]) break;
    --count;
    start = kAlways;
  }
  at[count] = static_cast<std::int16_t>(q);
  height[count] = height_sq;
  owner[count] = whose;
  from[count++] = start;
}

void NearestVoxels::compute(std::span<const Vector3> voxels_m, const VoxelGrid& around, const VoxelGrid& box) {
  around_ = around;
  box_ = box;
  low_ = box.min_cell - around.min_cell;
  empty_ = true;
  occupied_.assign(static_cast<std::size_t>(around.num_cells()), 0);
  row_occupied_.assign(static_cast<std::size_t>(around.size.y()) * around.size.z(), 0);
  // Coordinates begin two cells before the corner, so that truncation rounds down.
  const Vector3 from_m = (around.min_cell.array() - 2).cast<double>() * around.edge_m;
  const double per_edge = 1.0 / around.edge_m;
  for (const Vector3& voxel_m : voxels_m) {
    const Cell at = ((voxel_m - from_m) * per_edge).cast<int>().array() - 2;
    if ((at.array() < 0).any() || (at.array() >= around.size.array()).any()) continue;
    occupied_[static_cast<std::size_t>((at.z() * around.size.y() + at.y()) * around.size.x() + at.x())] = 1;
    row_occupied_[static_cast<std::size_t>(at.z()) * around.size.y() + at.y()] = 1;
    empty_ = false;
  }
  if (empty_) return;
  row_nearest_.resize(static_cast<std::size_t>(box.size.x()) * around.size.y() * around.size.z());
  area_nearest_.resize(static_cast<std::size_t>(box.size.x()) * box.size.y() * around.size.z());
  nearest_.resize(static_cast<std::size_t>(box.num_cells()));
  along_x();
  along_y();
  along_z();
}

// Two passes in each row: the last occupied voxel before, then behind each cell.
void NearestVoxels::along_x() {
  const int n = around_.size.x(), width = box_.size.x();
  const int num_rows = around_.size.y() * around_.size.z();
  for (int row = 0; row < num_rows; ++row) {
    const std::uint8_t* const occupied = &occupied_[static_cast<std::size_t>(row) * n];
    std::int32_t* const out = &row_nearest_[static_cast<std::size_t>(row) * width];
    if (row_occupied_[row] == 0) {
      std::fill_n(out, width, -1);
      continue;
    }
    int last = -1;
    for (int x = 0; x < low_.x() + width; ++x) {
      if (occupied[x] != 0) last = x;
      if (x >= low_.x()) out[x - low_.x()] = last;
    }
    last = -1;
    for (int x = n - 1; x >= low_.x(); --x) {
      if (occupied[x] != 0) last = x;
      if (x >= low_.x() + width || last < 0) continue;
      std::int32_t& nearest = out[x - low_.x()];
      if (nearest < 0 || last - x < x - nearest) nearest = last;
    }
  }
}

void NearestVoxels::along_y() {
  const int n = around_.size.y(), width = box_.size.x(), depth = box_.size.y();
  for (int z = 0; z < around_.size.z(); ++z) {
    for (int x = 0; x < width; ++x) {
      const std::int32_t* const in = &row_nearest_[static_cast<std::size_t>(z) * n * width + x];
      std::int32_t* const out = &area_nearest_[static_cast<std::size_t>(z) * depth * width + x];
      line_.clear();
      for (int y = 0; y < n; ++y) {
        const std::int32_t nearest = in[y * width];
        if (nearest >= 0) line_.add(y, squared(nearest - x - low_.x()), nearest | y << 10);
      }
      for (int y = 0, k = 0; y < depth; ++y) {
        while (k + 1 < line_.count && line_.from[k + 1] < static_cast<float>(y + low_.y())) ++k;
        out[y * width] = line_.count > 0 ? line_.owner[k] : -1;
      }
    }
  }
}

void NearestVoxels::along_z() {
  const int n = around_.size.z(), width = box_.size.x(), area = width * box_.size.y();
  for (int i = 0; i < area; ++i) {
    const int x = i % width + low_.x(), y = i / width + low_.y();
    line_.clear();
    for (int z = 0; z < n; ++z) {
      const std::int32_t nearest = area_nearest_[static_cast<std::size_t>(z) * area + i];
      if (nearest < 0) continue;
      line_.add(z, squared((nearest & 1023) - x) + squared((nearest >> 10) - y), nearest | z << 20);
    }
    for (int z = 0, k = 0; z < box_.size.z(); ++z) {
      while (k + 1 < line_.count && line_.from[k + 1] < static_cast<float>(z + low_.z())) ++k;
      nearest_[static_cast<std::size_t>(z) * area + i] = line_.owner[k];
    }
  }
}

}  // namespace swiftlet
