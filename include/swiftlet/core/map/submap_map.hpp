// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "swiftlet/core/map/composed_blocks.hpp"

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
class SubmapMap : public ComposedBlocks {
 public:
  explicit SubmapMap(const SubmapMapConfig& config);

  /// The hit time of a cell is that of the last scan of the newest piece in which it is occupied.
  void occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                       std::vector<Vector3>& centers_local_m) const override;
  bool changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const override;
  void append_voxels(MapVoxels& copy) const override;
  /// Appends the states of all blocks, in cells of the map.
  void append_blocks(std::vector<CellBlock>& blocks) const;
  /// Appends the centers of all occupied cells.
  void append_occupied(std::vector<Vector3>& centers_local_m) const;

  /// Share of a piece's cells that are known in newer pieces, sampled in one block of `every`.
  double share_known_by_newer(int piece, int every) const;
  /// Cells of a piece that affect the present map.
  std::shared_ptr<const SubmapCells> needed_of(int piece) const;
  /// Memory of the map without the pieces themselves.
  std::size_t bytes() const;

 private:
  /// Calls fn(block, its cells) for every block with known cells.
  template <class Fn>
  void for_known_blocks(Fn&& fn) const;
};

}  // namespace swiftlet
