// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "swiftlet/core/map/block_groups.hpp"
#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/map/placed_cells.hpp"

namespace swiftlet {

/// Pieces of a map at their poses, and the blocks composed of them. Evaluation is lazy: a block of 8 x 8 x 8 cells is
/// composed from the pieces that overlap it, and composed again after one of them was added, removed or moved. So
/// moving many pieces is cheap, and results do not depend on earlier queries.
class ComposedBlocks : public BlockOccupancy {
 public:
  /// Returns the index of the piece.
  /// @param age   pieces with a greater age are newer; for equal ages, the one added later
  /// @param seen  time of its last scan
  int add(std::shared_ptr<const SubmapCells> cells, const Pose& T_local_cells, int age, TimeNs seen);
  /// False when the pose is unchanged.
  bool move(int piece, const Pose& T_local_cells);
  void remove(int piece);
  /// Replaces the cells of a piece without changing its pose.
  void replace(int piece, std::shared_ptr<const SubmapCells> cells);
  /// Sets the growing piece, the newest of all; null: none. Its cells are aligned with those of this map, with a block
  /// offset from its own origin. Must be called after every change of the growing piece.
  void set_growing(const OccupancyMap* growing, const Cell& offset_blocks);

  int num_pieces() const { return num_pieces_; }
  const SubmapCells& cells(int piece) const { return pieces_[static_cast<std::size_t>(piece)].placed.cells(); }
  /// Pose in use, rounded.
  const Pose& T_local_cells(int piece) const { return pieces_[static_cast<std::size_t>(piece)].placed.T_local_cells(); }
  /// Number of pose changes of pieces.
  std::uint64_t num_moved() const { return num_moved_; }
  /// Number of composed blocks.
  std::uint64_t num_composed() const { return num_composed_; }

 protected:
  /// Index without a piece.
  static constexpr std::uint32_t kNoPiece = 0xFFFFFFFFU;
  struct Piece {
    PlacedCells placed;  // empty: removed
    int age = 0;
    std::uint64_t number = 0;  // serial number
    TimeNs seen = 0;
    std::vector<std::uint32_t> groups;  // groups that the piece overlaps
  };
  struct Composed {
    Bits occupied{}, free{};
  };

  /// @param outvoted_by  see SubmapMapConfig
  ComposedBlocks(double edge_m, double distance_max_m, int outvoted_by);
  const Bits* occupied_of(const Cell& block) const override;
  /// Changes name whole blocks: the changed cells are unknown until the block is composed again.
  void append_changes(const Cell& low, const Cell& high, std::uint64_t since,
                      std::vector<Change>& changes) const override;
  CellState state_of(const Cell& cell) const override;

  const Piece& piece(std::uint32_t i) const;
  /// Copies the cells of a piece in a block; false: all unknown.
  bool look(const Piece& piece, const Cell& block, Bits& occupied, Bits& free) const;
  /// Composes a block of all pieces but one.
  void compose(const BlockGroup& group, const Cell& block, std::uint32_t but, Composed& made) const;
  /// Present cells of a block; null: all unknown.
  const Composed* composed(const Cell& block) const;
  const Composed* composed(BlockGroup& group, const Cell& block) const;
  std::size_t bytes() const;

  BlockGroups groups_;
  const OccupancyMap* growing_ = nullptr;
  Cell growing_offset_blocks_ = Cell::Zero();

 private:
  static constexpr std::size_t kChunk = 256;  // number of blocks per allocation

  void place(std::uint32_t piece, const Pose& T_local_cells);
  void displace(std::uint32_t piece);
  bool is_older(std::uint32_t a, std::uint32_t b) const;
  bool look_growing(const Cell& block, Bits& occupied, Bits& free) const;
  void note_grown(std::uint64_t since);

  int outvoted_by_;
  std::vector<Piece> pieces_;
  std::vector<std::uint32_t> free_pieces_;
  int num_pieces_ = 0;
  std::uint64_t num_added_ = 0, num_moved_ = 0;
  std::uint64_t growing_revision_ = 0;
  std::vector<VoxelGrid> grown_;  // scratch
  // Lazily computed.
  mutable std::vector<std::unique_ptr<Composed[]>> chunks_;
  mutable std::size_t num_blocks_ = 0;
  mutable std::uint64_t num_composed_ = 0;
  mutable PlacedCells::Overlap overlap_;  // scratch
};

}  // namespace swiftlet
