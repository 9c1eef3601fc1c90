// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/map/cell_block.hpp"

namespace swiftlet {

/// A piece of a map in its own frame: observed occupied and free cells. Immutable. Its pose is stored elsewhere, and
/// may change.
class SubmapCells {
 public:
  static constexpr int kSide = CellBlock::kSide;
  static constexpr int kGroup = 4;                     ///< edge of a group in blocks
  static constexpr int kGroup_cells = kGroup * kSide;  ///< edge of a group in cells
  using Bits = CellBlock::Bits;

  /// Blocks without known cells are omitted.
  /// @param blocks  at most one per position
  SubmapCells(double edge_m, std::span<const CellBlock> blocks);
  /// Cells of a cloud in the frame of the piece, such as a submap's without cast rays: no cell is free.
  static SubmapCells of_points(double edge_m, std::span<const Eigen::Vector3f> points_cells_m);

  double edge_m() const { return edge_m_; }
  bool empty() const { return at_.empty(); }
  std::size_t num_blocks() const { return at_.size(); }
  /// Index of a block; -1: all its cells are unknown.
  int find(const Cell& block) const;
  const Cell& at(int i) const { return at_[static_cast<std::size_t>(i)]; }
  const Bits& free_of(int i) const { return free_[static_cast<std::size_t>(i)]; }
  /// Null when no cell of the block is occupied.
  const Bits* occupied_of(int i) const {
    const std::uint32_t place = occupied_place_[static_cast<std::size_t>(i)];
    return place == 0 ? nullptr : &occupied_[place - 1];
  }
  std::size_t num_occupied() const { return num_occupied_; }
  std::size_t num_free() const { return num_free_; }
  /// Center of the box around its blocks, in the frame of the piece.
  Vector3 middle_m() const { return middle_m_; }
  double reach_m() const { return reach_m_; }  ///< from the center to a corner of the box
  /// Groups of 4 x 4 x 4 blocks with known cells.
  std::span<const Cell> groups() const { return groups_; }
  std::size_t bytes() const;

 private:
  std::size_t slot_of(const Cell& block) const;

  double edge_m_;
  std::vector<Cell> at_;
  std::vector<Bits> free_;
  std::vector<std::uint32_t> occupied_place_;  // index + 1; 0: none
  std::vector<Bits> occupied_;
  std::vector<std::uint32_t> slots_;  // block index + 1; open addressing
  std::vector<Cell> groups_;
  std::size_t num_occupied_ = 0, num_free_ = 0;
  Vector3 middle_m_ = Vector3::Zero();
  double reach_m_ = 0.0;
};

/// Cells attached to a submap of a pose graph.
struct MapPiece {
  int submap = 0;  ///< number of the submap
  Pose T_submap_cells = Pose::Identity();
  std::shared_ptr<const SubmapCells> cells;
};

}  // namespace swiftlet
