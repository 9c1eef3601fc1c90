// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Cubic cells of a box, indexed along x first, then y, then z.
struct CellGrid {
  Vector3 origin_world_m = Vector3::Zero();  ///< corner of cell 0
  double cell_m = 1.0;
  Eigen::Vector3i size = Eigen::Vector3i::Zero();  ///< cells along each axis

  std::size_t num_cells() const;
  int index_of(const Eigen::Vector3i& cell) const { return (cell.z() * size.y() + cell.y()) * size.x() + cell.x(); }
  Eigen::Vector3i cell_of(int index) const;
  /// Cell of a position; clamped to the box.
  Eigen::Vector3i cell_at(const Vector3& p_world_m) const;
  Vector3 center_of(int index) const;
};

/// Interface of the planning space, in which the vehicle is a point.
class FreeSpaceView {
 public:
  virtual ~FreeSpaceView() = default;

  /// Grid of the path search.
  virtual const CellGrid& grid() const = 0;
  virtual bool is_free(const Vector3& p_world_m) const = 0;
  /// is_free() at the center of a cell; called often.
  virtual bool is_free_cell(int index) const = 0;
};

/// True when points half a cell apart on the segment are all free.
bool is_free_segment(const FreeSpaceView& space, const Vector3& a_world_m, const Vector3& b_world_m);

}  // namespace swiftlet
