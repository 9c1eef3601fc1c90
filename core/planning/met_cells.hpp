// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// Cells visited by a search, found by their coordinates.
class MetCells {
 public:
  struct Node {
    Cell cell;
    double cost = std::numeric_limits<double>::infinity();
    int parent = -1;
    bool clear = false, closed = false;
  };

  MetCells() : slots_(1U << 14U, -1) {}
  /// Index of the node; a new one calls is_clear(cell).
  template <class IsClear>
  int meet(const Cell& cell, IsClear&& is_clear) {
    std::size_t slot = slot_of(cell);
    if (slots_[slot] < 0) {
      if (2 * (nodes_.size() + 1) > slots_.size()) {
        grow();
        slot = slot_of(cell);
      }
      slots_[slot] = static_cast<int>(nodes_.size());
      nodes_.push_back({.cell = cell});
      nodes_.back().clear = is_clear(cell);
    }
    return slots_[slot];
  }
  Node& operator[](int i) { return nodes_[static_cast<std::size_t>(i)]; }
  const Node& operator[](int i) const { return nodes_[static_cast<std::size_t>(i)]; }

 private:
  std::size_t slot_of(const Cell& cell) const {
    const auto part = [](int c) { return static_cast<std::uint64_t>(c) & 0x1FFFFFU; };
    const std::uint64_t key = part(cell.x()) | part(cell.y()) << 21U | part(cell.z()) << 42U;
    std::size_t slot = (key * 0x9E3779B97F4A7C15ULL >> 32U) & (slots_.size() - 1);
    while (slots_[slot] >= 0 && nodes_[static_cast<std::size_t>(slots_[slot])].cell != cell) {
      slot = (slot + 1) & (slots_.size() - 1);
    }
    return slot;
  }
  void grow() {
    slots_.assign(2 * slots_.size(), -1);
    for (std::size_t i = 0; i < nodes_.size(); ++i) slots_[slot_of(nodes_[i].cell)] = static_cast<int>(i);
  }

  std::vector<int> slots_;
  std::vector<Node> nodes_;
};

struct OpenCell {
  double cost;  // cost so far plus the remaining one, in cells
  int node;
  // Ties in cost go to the newest cell, which is deeper and deterministic.
  bool operator<(const OpenCell& other) const { return cost != other.cost ? cost > other.cost : node < other.node; }
};

}  // namespace swiftlet
