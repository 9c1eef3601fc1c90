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

/// Map composed of pieces in the local frame that may be moved, added and removed. The state of a cell depends only on
/// the pieces and their present poses. So a moved piece leaves no traces.
///
/// - A cell is occupied when a piece has an occupied cell there: the center of one of the two lies in the other. So
///   rotations make no holes in walls. It is free when a piece has a free cell at its center and no piece an occupied
///   one.
/// - Occupied cells of an older piece are cleared when `outvoted_by` newer pieces in a row observe them free; 0: never.
/// - Poses are rounded to a quarter of a cell, at the center of a piece and at its rim.
///
/// Evaluation is lazy. A block of 8 x 8 x 8 cells is composed from the pieces that overlap it, and recomposed after one
/// of them was added, removed or moved. So moving many pieces is cheap, and results do not depend on earlier queries.
class SubmapMap : public OccupancyView, private OccupiedBlocks {
 public:
  explicit SubmapMap(const SubmapMapConfig& config);

  /// Returns the index of the piece.
  /// @param age   pieces with a greater age are newer; for equal ages, the one added later
  /// @param seen  time of its last scan
  int add(std::shared_ptr<const SubmapCells> cells, const Pose& T_local_cells, int age, TimeNs seen);
  /// False when the pose is unchanged.
  bool move(int piece, const Pose& T_local_cells);
  void remove(int piece);
  /// Sets the growing piece, the newest of all; null: none. Its cells are aligned with those of this map, with a block
  /// offset from its own origin. Must be called after every change of the growing piece.
  void set_growing(const OccupancyMap* growing, const Cell& offset_blocks);

  double edge_m() const override { return config_.edge_m; }
  CellState state(const Vector3& p_local_m) const override;
  /// The hit time of a cell is that of the last scan of the newest piece in which it is occupied.
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
  /// Appends the states of all blocks, in cells of the map.
  void append_blocks(std::vector<CellBlock>& blocks) const;
  /// Appends the centers of all occupied cells.
  void append_occupied(std::vector<Vector3>& centers_local_m) const;

  /// Share of a piece's cells that are known in newer pieces, sampled in one block of `every`.
  double share_known_by_newer(int piece, int every) const;
  /// Cells of a piece that affect the present map.
  std::shared_ptr<const SubmapCells> needed_of(int piece) const;
  /// Replaces the cells of a piece without changing its pose.
  void replace(int piece, std::shared_ptr<const SubmapCells> cells);

  int num_pieces() const { return num_pieces_; }
  const SubmapCells& cells(int piece) const { return *pieces_[static_cast<std::size_t>(piece)].cells; }
  /// Pose in use, rounded.
  const Pose& T_local_cells(int piece) const { return pieces_[static_cast<std::size_t>(piece)].T_local_cells; }
  /// Number of pose changes of pieces.
  std::uint64_t num_moved() const { return num_moved_; }
  /// Number of composed blocks.
  std::uint64_t num_composed() const { return num_composed_; }
  /// Memory of the map without the pieces themselves.
  std::size_t bytes() const;

 private:
  static constexpr int kSide = RayCells::kSide;
  static constexpr int kGroup = SubmapCells::kGroup;
  using Bits = RayCells::Bits;
  struct Piece {
    std::shared_ptr<const SubmapCells> cells;  // null: removed
    int age = 0;
    std::uint64_t number = 0;  // serial number
    TimeNs seen = 0;
    Vector3 middle_cells_m = Vector3::Zero();  // center of the original cells; rounding of the pose refers to it
    double reach_m = 0.0;
    Pose T_local_cells = Pose::Identity();  // pose in use, rounded
    bool aligned = false;                   // blocks coincide with those of the map
    Cell offset_blocks = Cell::Zero();      // block offset, if aligned
    // Cell coordinates of the map to those of the piece and back: p_cells = M p_local + o_cells.
    Matrix3 M = Matrix3::Identity(), M_back = Matrix3::Identity();
    Vector3 o_cells = Vector3::Zero();
    std::vector<std::uint32_t> groups;  // groups that the piece overlaps
  };
  struct Composed {
    Bits occupied{}, free{};
  };
  /// Composition state of a block of the map.
  struct Slot {
    std::uint64_t changed = 0, composed = 0;  // revisions: last change by the growing piece, last composition
    std::int32_t block = -1;                  // -1: never known
    bool any_occupied = false;
  };
  struct Group {
    Cell at = Cell::Zero();
    std::uint64_t moved = 0;            // revision at which a piece was added, removed or moved last
    std::vector<std::uint32_t> pieces;  // sorted from old to new
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
  /// Copies the cells of a piece in a block; false: all unknown.
  bool look(const Piece& piece, const Cell& block, Bits& occupied, Bits& free) const;
  /// Copies at least the wanted cells.
  bool look(const Piece& piece, const Cell& block, const Bits& wanted, Bits& occupied, Bits& free) const;
  bool look_turned(const Piece& piece, const Cell& block, const Bits& wanted, Bits& occupied, Bits& free) const;
  bool look_growing(const Cell& block, Bits& occupied, Bits& free) const;
  static constexpr std::uint32_t kAll = 0xFFFFFFFFU;
  void compose(const Group& group, const Cell& block, std::uint32_t but, Composed& made) const;
  /// Present cells of a block; null: all unknown.
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

  // Lazily computed.
  static constexpr std::size_t kChunk = 256;
  std::vector<std::unique_ptr<Group>> groups_;
  std::vector<std::uint32_t> group_slots_;  // index + 1; open addressing
  mutable Group* last_group_ = nullptr;     // group of the last query
  mutable std::vector<std::unique_ptr<Composed[]>> chunks_;
  mutable std::size_t num_blocks_ = 0;
  mutable std::uint64_t num_composed_ = 0;
  mutable std::vector<int> near_;  // scratch: block indices of a piece
  mutable DistanceTiles distances_;
};

}  // namespace swiftlet
