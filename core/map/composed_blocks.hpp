// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/map/block_groups.hpp"
#include "core/map/block_occupancy.hpp"
#include "core/map/placed_cells.hpp"
#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/map/submap_map.hpp"

namespace swiftlet {

/// Pieces of a map at their poses, and the blocks composed of them. Evaluation is lazy: a block of 8 x 8 x 8 cells is
/// composed from the pieces that overlap it, and composed again after one of them was added, removed or moved. So
/// moving many pieces is cheap, and results do not depend on earlier queries.
class ComposedBlocks : public BlockOccupancy<SubmapMap> {
 public:
  CellState state(const Vector3& p_local_m) const override;

  int add(std::shared_ptr<const SubmapCells> cells, const Pose& T_local_cells, int age, TimeNs seen) override;
  bool move(int piece, const Pose& T_local_cells) override;
  void remove(int piece) override;
  void replace(int piece, std::shared_ptr<const SubmapCells> cells) override;
  void set_growing(const OccupancyMap* growing, const Cell& offset_blocks) override;

  int num_pieces() const override { return num_pieces_; }
  const SubmapCells& cells(int piece) const override { return pieces_[static_cast<std::size_t>(piece)].placed.cells(); }
  const Pose& T_local_cells(int piece) const override {
    return pieces_[static_cast<std::size_t>(piece)].placed.T_local_cells();
  }
  std::uint64_t num_moved() const override { return num_moved_; }
  std::uint64_t num_composed() const override { return num_composed_; }

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

  const Piece& piece(std::uint32_t i) const;
  /// Copies the cells of a piece in a block; false: all unknown.
  bool look(const Piece& piece, const Cell& block, Bits& occupied, Bits& free) const;
  /// Composes a block of all pieces but one.
  void compose(const BlockGroup& group, const Cell& block, std::uint32_t but, Composed& made) const;
  /// Present cells of a block; null: all unknown.
  const Composed* composed(const Cell& block) const;
  const Composed* composed(BlockGroup& group, const Cell& block) const;
  /// Memory of the pieces' places and the blocks.
  std::size_t bytes_of_blocks() const;

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
