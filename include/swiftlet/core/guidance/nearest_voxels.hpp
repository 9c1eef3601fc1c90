// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// The nearest of some voxels for every cell of a box on the same lattice, by the distance of centers. It is an exact
/// feature transform, one axis after the other, of which only what the box asks for is computed. (A. Meijster, J.
/// Roerdink, W. Hesselink, "A general algorithm for computing distance transforms in linear time", 2000; P.
/// Felzenszwalb, D. Huttenlocher, 2012.) Any frame, the same for all arguments.
class NearestVoxels {
 public:
  /// @param around  voxels in these cells count; at most 1023 by axis
  /// @param box     answers are wanted for these; within `around`
  void compute(std::span<const Vector3> voxels_m, const VoxelGrid& around, const VoxelGrid& box);

  /// Whether there is any voxel.
  bool empty() const { return empty_; }
  /// The nearest voxel's cell, counted from the corner of `around`; for a cell counted from the corner of the box.
  Cell nearest(const Cell& in_box) const {
    const std::int32_t packed =
        nearest_[static_cast<std::size_t>((in_box.z() * box_.size.y() + in_box.y()) * box_.size.x() + in_box.x())];
    return {packed & 1023, packed >> 10 & 1023, packed >> 20};
  }

 private:
  /// The parabolas of one line: where they are, how high they stand and who they belong to.
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
  Cell low_ = Cell::Zero();  // of the box in the cells around
  bool empty_ = true;
  std::vector<std::uint8_t> occupied_;      // cells around
  std::vector<std::uint8_t> row_occupied_;  // rows of them
  std::vector<std::int32_t> row_nearest_;   // x of the box, y and z around: along the row
  std::vector<std::int32_t> area_nearest_;  // x and y of the box, z around: in the layer
  std::vector<std::int32_t> nearest_;       // the box
  Line line_;
};

}  // namespace swiftlet
