// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// Nearest of a set of voxels for every cell of a box on the same lattice, by the distance of centers. Exact feature
/// transform, axis by axis, restricted to the cells that affect the box. (A. Meijster, J. Roerdink, W. Hesselink, "A
/// general algorithm for computing distance transforms in linear time", 2000; P. Felzenszwalb, D. Huttenlocher, 2012.)
/// Any frame, the same for all arguments.
class NearestVoxels {
 public:
  /// @param around  only voxels in these cells count; at most 1023 by axis
  /// @param box     cells for which nearest() is valid; within `around`
  void compute(std::span<const Vector3> voxels_m, const VoxelGrid& around, const VoxelGrid& box);

  /// True when there is no voxel.
  bool empty() const { return empty_; }
  /// Cell of the nearest voxel, relative to the corner of `around`. @param in_box  relative to the corner of the box
  Cell nearest(const Cell& in_box) const {
    const std::int32_t packed =
        nearest_[static_cast<std::size_t>((in_box.z() * box_.size.y() + in_box.y()) * box_.size.x() + in_box.x())];
    return {packed & 1023, packed >> 10 & 1023, packed >> 20};
  }

 private:
  /// Lower envelope of the parabolas of one line: positions, heights, intersections and owners.
  struct Line {
    std::array<std::int16_t, 1024> at;
    std::array<float, 1024> height, from;
    std::array<std::int32_t, 1024> owner;
    int count = 0;

    void clear() { count = 0; }
    void add(int q, float height_sq, std::int32_t whose);
  };
  void along_x();
  void along_y();
  void along_z();

  VoxelGrid around_, box_;
  Cell low_ = Cell::Zero();  // corner of the box, relative to that of `around`
  bool empty_ = true;
  std::vector<std::uint8_t> occupied_;      // cells of `around`
  std::vector<std::uint8_t> row_occupied_;  // rows of `around`
  std::vector<std::int32_t> row_nearest_;   // nearest along the row: x of the box, y and z of `around`
  std::vector<std::int32_t> area_nearest_;  // nearest in the layer: x and y of the box, z of `around`
  std::vector<std::int32_t> nearest_;       // nearest of all, for the box
  Line line_;
};

}  // namespace swiftlet
