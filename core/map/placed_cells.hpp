// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "swiftlet/core/map/submap_cells.hpp"

namespace swiftlet {

/// Cells of a submap placed at a pose in a map, resampled to the cells of the map, which have other edges and axes.
class PlacedCells {
 public:
  using Bits = CellBlock::Bits;

  PlacedCells() = default;  ///< no cells
  /// @param edge_m  edge of the map's cells
  PlacedCells(std::shared_ptr<const SubmapCells> cells, double edge_m);

  bool empty() const { return cells_ == nullptr; }
  const SubmapCells& cells() const { return *cells_; }
  /// Other cells of the same piece; poses are rounded as before.
  void replace(std::shared_ptr<const SubmapCells> cells) { cells_ = std::move(cells); }
  /// Pose rounded to a quarter of a cell, at the center of the first cells and at their rim. Depends on the pose alone,
  /// not on earlier poses.
  Pose rounded(const Pose& T_local_cells) const;
  void place(const Pose& T_local_cells);
  const Pose& T_local_cells() const { return T_local_cells_; }
  /// Groups of the map's blocks that groups of the cells overlap, with duplicates.
  std::vector<Cell> overlapped_groups() const;

  /// Blocks of the piece that overlap a block of the map. Reused as scratch.
  struct Overlap {
    Cell low = Cell::Zero(), size = Cell::Zero();
    std::vector<int> blocks;  ///< indices, x first; -1: unknown
    bool any_occupied = false;
  };
  /// Sets at least the wanted cells of a block of the map; false: all unknown. A cell is occupied when its center lies
  /// in an occupied cell of the piece, or vice versa; free when its center lies in a free cell.
  bool look(const Cell& block, const Bits& wanted, Overlap& overlap, Bits& occupied, Bits& free) const;
  /// Cells of the piece that decide on a cell of the map.
  void append_deciding(const Cell& map_cell, std::vector<Cell>& cells) const;

 private:
  bool find_overlap(const Cell& block, Overlap& overlap) const;
  void sample_centers(const Cell& block, const Bits& wanted, const Overlap& overlap, Bits& occupied, Bits& free) const;
  void mark_occupied(const Cell& block, const Overlap& overlap, Bits& occupied) const;

  std::shared_ptr<const SubmapCells> cells_;
  double edge_m_ = 0.0;
  Vector3 middle_cells_m_ = Vector3::Zero();  // center of the first cells; rounding of the pose refers to it
  double reach_m_ = 0.0;
  Pose T_local_cells_ = Pose::Identity();
  bool aligned_ = false;               // blocks coincide with those of the map
  Cell offset_blocks_ = Cell::Zero();  // block offset, if aligned
  // Cell coordinates of the map to those of the piece and back: p_cells = M p_local + o_cells.
  Matrix3 M_ = Matrix3::Identity(), M_back_ = Matrix3::Identity();
  Vector3 o_cells_ = Vector3::Zero();
};

}  // namespace swiftlet
