// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "swiftlet/core/map/cell_block.hpp"
#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/map/submap_cells.hpp"

namespace swiftlet {

struct SubmapMapConfig {
  double edge_m = 0.2;
  int outvoted_by = 2;
  double distance_max_m = 2.0;
};

/// Map composed of pieces in the local frame that may be moved, added and removed. The state of a cell depends only on
/// the pieces and their present poses. So a moved piece leaves no traces.
///
/// - A cell is occupied when a piece has an occupied cell there: the center of one of the two lies in the other. So
///   rotations make no holes in walls. It is free when a piece has a free cell at its center and no piece an occupied
///   one.
/// - Occupied cells of an older piece are cleared when `outvoted_by` newer pieces in a row observe them free; 0: never.
/// - Poses are rounded to a quarter of a cell, at the center of a piece and at its rim.
/// - The hit time of a cell is that of the last scan of the newest piece in which it is occupied.
class SubmapMap : public OccupancyView {
 public:
  /// Returns the index of the piece.
  /// @param age   pieces with a greater age are newer; for equal ages, the one added later
  /// @param seen  time of its last scan
  virtual int add(std::shared_ptr<const SubmapCells> cells, const Pose& T_local_cells, int age, TimeNs seen) = 0;
  /// False when the pose is unchanged.
  virtual bool move(int piece, const Pose& T_local_cells) = 0;
  virtual void remove(int piece) = 0;
  /// Replaces the cells of a piece without changing its pose.
  virtual void replace(int piece, std::shared_ptr<const SubmapCells> cells) = 0;
  /// Sets the growing piece, the newest of all; null: none. Its cells are aligned with those of this map, with a block
  /// offset from its own origin. Must be called after every change of the growing piece.
  virtual void set_growing(const OccupancyMap* growing, const Cell& offset_blocks) = 0;

  virtual int num_pieces() const = 0;
  virtual const SubmapCells& cells(int piece) const = 0;
  /// Pose in use, rounded.
  virtual const Pose& T_local_cells(int piece) const = 0;
  /// Number of pose changes of pieces.
  virtual std::uint64_t num_moved() const = 0;
  /// Number of composed blocks.
  virtual std::uint64_t num_composed() const = 0;

  /// Appends the states of all blocks, in cells of the map.
  virtual void append_blocks(std::vector<CellBlock>& blocks) const = 0;
  /// Appends the centers of all occupied cells.
  virtual void append_occupied(std::vector<Vector3>& centers_local_m) const = 0;

  /// Share of a piece's cells that are known in newer pieces, sampled in one block of `every`.
  virtual double share_known_by_newer(int piece, int every) const = 0;
  /// Cells of a piece that affect the present map.
  virtual std::shared_ptr<const SubmapCells> needed_of(int piece) const = 0;
  /// Memory of the map without the pieces themselves.
  virtual std::size_t bytes() const = 0;
};

std::unique_ptr<SubmapMap> make_submap_map(const SubmapMapConfig& config);

}  // namespace swiftlet
