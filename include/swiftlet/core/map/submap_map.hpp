// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "swiftlet/core/map/distance_tiles.hpp"
#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/map/submap_cells.hpp"

namespace swiftlet {

struct SubmapMapConfig {
  double edge_m = 0.2;
  int outvoted_by = 2;
  double distance_max_m = 2.0;
};

/// A map made of pieces that lie in the local frame, and that may be moved, added and taken out. What a cell is follows
/// from the pieces and where they lie now, and from nothing else. So nothing is left behind when a piece moves.
///
/// - A cell is occupied when a piece has an occupied cell there: the center of one of the two lies in the other. So a
///   turn makes no holes in walls. It is free when some piece has a free cell at its center and none an occupied one.
/// - What an older piece saw occupied goes when `outvoted_by` newer ones in a row saw it free; with 0 it stays for
/// ever.
/// - Poses are taken to a quarter of a cell, in the middle of a piece and at its rim.
///
/// Nothing is worked out before it is asked for. A block of 8 x 8 x 8 cells is made from the pieces that reach into it.
/// It is made anew when one of these came, went or moved. So moving many pieces costs little, and the answers do not
/// hang on what was asked before.
class SubmapMap : public OccupancyView, private OccupiedBlocks {
 public:
  explicit SubmapMap(const SubmapMapConfig& config);

  /// Returns a number by which to name the piece.
  /// @param age   pieces with a greater one are newer; of equal ones that which is added later
  /// @param seen  when its last scan was made
  int add(std::shared_ptr<const SubmapCells> cells, const Pose& T_local_cells, int age, TimeNs seen);
  /// False when it lies there already.
  bool move(int piece, const Pose& T_local_cells);
  void remove(int piece);
  /// The piece that still grows, newest of all; null: none. Its cells lie on those of this map, so many blocks from its
  /// own origin. To be told again whenever it has grown.
  void set_growing(const OccupancyMap* growing, const Cell& offset_blocks);

  double edge_m() const override { return config_.edge_m; }
  CellState state(const Vector3& p_local_m) const override;
  /// Of a cell that pieces saw occupied counts when the newest of these made its last scan.
  void occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                       std::vector<Vector3>& centers_local_m) const override;
  void occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                   std::vector<Vector3>& centers_local_m) const override;
  double distance_m(const Vector3& p_local_m, double max_m) const override;
  double clearance_m(const Vector3& p_local_m, double max_m) const override;
  std::optional<SegmentHit> first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const override;
  std::uint64_t revision() const override { return revision_; }
  bool changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const override;
  void append_voxels(MapVoxels& copy) const override;
  /// What is known of each block, in cells of the map.
  void append_blocks(std::vector<CellBlock>& blocks) const;
  /// All occupied cells.
  void append_occupied(std::vector<Vector3>& centers_local_m) const;

  /// Of the cells of a piece, which share do newer pieces know? One block in `every` is looked at.
  double share_known_by_newer(int piece, int every) const;
  /// The cells of a piece without which the map would be another one, by all that lies where it lies now.
  std::shared_ptr<const SubmapCells> needed_of(int piece) const;
  /// Takes these in place of the cells of a piece, which lies where it did.
  void replace(int piece, std::shared_ptr<const SubmapCells> cells);

  int num_pieces() const { return num_pieces_; }
  const SubmapCells& cells(int piece) const { return *pieces_[static_cast<std::size_t>(piece)].cells; }
  /// As it is used.
  const Pose& T_local_cells(int piece) const { return pieces_[static_cast<std::size_t>(piece)].T_local_cells; }
  /// How often a piece was put somewhere else.
  std::uint64_t num_moved() const { return num_moved_; }
  /// How often a block was worked out.
  std::uint64_t num_composed() const { return num_composed_; }
  /// All that it holds but the pieces themselves.
  std::size_t bytes() const;

 private:
  static constexpr int kSide = RayCells::kSide;
  static constexpr int kGroup = SubmapCells::kGroup;
  using Bits = RayCells::Bits;
  struct Piece {
    std::shared_ptr<const SubmapCells> cells;  // null: taken out
    int age = 0;
    std::uint64_t number = 0;  // of all that were ever added
    TimeNs seen = 0;
    Vector3 middle_cells_m = Vector3::Zero();  // of the cells that came with it: its pose is taken to a lattice by them
    double reach_m = 0.0;
    Pose T_local_cells = Pose::Identity();  // as it is used
    bool aligned = false;                   // its blocks are those of the map
    Cell offset_blocks = Cell::Zero();      // when they are
    // From cells of the map to those of the piece and back: p_cells = M p_local + o_cells, in cells of each.
    Matrix3 M = Matrix3::Identity(), M_back = Matrix3::Identity();
    Vector3 o_cells = Vector3::Zero();
    std::vector<std::uint32_t> groups;  // into which it reaches
  };
  struct Composed {
    Bits occupied{}, free{};
  };
  /// Of a block of the map.
  struct Slot {
    std::uint64_t changed = 0, composed = 0;  // revisions: when the growing piece changed it, when it was worked out
    std::int32_t block = -1;                  // none: nothing was ever known there
    bool any_occupied = false;
  };
  struct Group {
    Cell at = Cell::Zero();
    std::uint64_t moved = 0;            // the revision in which a piece came, went or moved last
    std::vector<std::uint32_t> pieces;  // from the oldest on
    std::array<Slot, kGroup * kGroup * kGroup> slots;
  };

  static Cell group_of(const Cell& block) { return {block.x() >> 2, block.y() >> 2, block.z() >> 2}; }
  static std::size_t slot_in_group(const Cell& block) {
    return static_cast<std::size_t>((block.x() & 3) | (block.y() & 3) << 2 | (block.z() & 3) << 4);
  }
  Cell cell_of(const Vector3& p_local_m) const { return (p_local_m.array() * cells_per_m_).floor().cast<int>(); }
  Vector3 center_of(const Cell& cell) const { return (cell.cast<double>().array() + 0.5) * config_.edge_m; }
  std::size_t group_slot(const Cell& group) const;
  Group* find_group(const Cell& group) const;
  std::uint32_t find_or_make_group(const Cell& group);
  bool is_older(std::uint32_t a, std::uint32_t b) const;
  Pose snapped(const Piece& piece, const Pose& T_local_cells) const;
  void place(std::uint32_t piece, const Pose& T_local_cells);
  void displace(std::uint32_t piece);
  /// What a piece knows of a block; false: nothing.
  bool look(const Piece& piece, const Cell& block, Bits& occupied, Bits& free) const;
  /// The same, at least of the wanted cells.
  bool look(const Piece& piece, const Cell& block, const Bits& wanted, Bits& occupied, Bits& free) const;
  bool look_turned(const Piece& piece, const Cell& block, const Bits& wanted, Bits& occupied, Bits& free) const;
  bool look_growing(const Cell& block, Bits& occupied, Bits& free) const;
  static constexpr std::uint32_t kAll = 0xFFFFFFFFU;
  void compose(const Group& group, const Cell& block, std::uint32_t but, Composed& made) const;
  /// As of now; null: nothing is known there.
  const Composed* composed(const Cell& block) const;
  const Composed* composed(Group& group, const Cell& block) const;
  CellState state_of(const Cell& cell) const;
  const Bits* occupied_of(const Cell& block) const override;
  void append_changes(const Cell& low, const Cell& high, std::uint64_t since,
                      std::vector<Change>& changes) const override;
  template <class Fn>
  void for_occupied_blocks(const Vector3& min_local_m, const Vector3& max_local_m, Fn&& fn) const;
  template <class Fn>
  void for_occupied(const Vector3& min_local_m, const Vector3& max_local_m, Fn&& fn) const;
  void note_grown(std::uint64_t since);

  SubmapMapConfig config_;
  double cells_per_m_;
  std::vector<Piece> pieces_;
  std::vector<std::uint32_t> free_pieces_;
  int num_pieces_ = 0;
  std::uint64_t num_added_ = 0;
  const OccupancyMap* growing_ = nullptr;
  Cell growing_offset_blocks_ = Cell::Zero();
  std::uint64_t growing_revision_ = 0;
  std::vector<VoxelGrid> grown_;  // scratch
  std::uint64_t revision_ = 0;
  std::uint64_t num_moved_ = 0;

  // Made when it is asked for.
  static constexpr std::size_t kChunk = 256;
  std::vector<std::unique_ptr<Group>> groups_;
  std::vector<std::uint32_t> group_slots_;  // counted from 1: open addressing
  mutable Group* last_group_ = nullptr;     // asked for
  mutable std::vector<std::unique_ptr<Composed[]>> chunks_;
  mutable std::size_t num_blocks_ = 0;
  mutable std::uint64_t num_composed_ = 0;
  mutable std::vector<int> near_;  // scratch: blocks of a piece
  mutable DistanceTiles distances_;
};

}  // namespace swiftlet
