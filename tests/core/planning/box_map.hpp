// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet::testing {

/// A box of cells with given states; unknown outside.
class BoxMap : public OccupancyView {
 public:
  BoxMap(const Cell& size, double edge_m) : edge_m_(edge_m) {
    grid_.edge_m = edge_m;
    grid_.size = size;
    states_.assign(static_cast<std::size_t>(grid_.num_cells()), CellState::kFree);
  }
  CellState& at(const Cell& cell) { return states_[static_cast<std::size_t>(grid_.index(cell))]; }
  CellState at(const Cell& cell) const {
    return grid_.contains(cell) ? states_[static_cast<std::size_t>(grid_.index(cell))] : CellState::kUnknown;
  }
  const VoxelGrid& grid() const { return grid_; }

  std::uint64_t now = 0;  ///< the revision

  double edge_m() const override { return edge_m_; }
  CellState state(const Vector3& p_m) const override { return at(cell_of(p_m)); }
  void occupied_within(const Vector3&, double, TimeNs, std::vector<Vector3>&) const override {}
  void occupied_in(const Vector3& min_m, const Vector3& max_m, std::vector<Vector3>& centers_m) const override {
    centers_m.clear();
    const Cell low = cell_of(min_m), high = cell_of(max_m);
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          if (at(Cell(x, y, z)) == CellState::kOccupied) centers_m.push_back(grid_.center_m({x, y, z}));
        }
      }
    }
  }
  double distance_m(const Vector3&, double max_m) const override { return max_m; }
  std::optional<SegmentHit> first_hit(const Vector3&, const Vector3&) const override { return std::nullopt; }
  std::uint64_t revision() const override { return now; }
  bool changed_since(std::uint64_t, std::vector<VoxelGrid>&) const override { return false; }

 private:
  Cell cell_of(const Vector3& p_m) const { return (p_m.array() / edge_m_).floor().cast<int>(); }
  double edge_m_;
  VoxelGrid grid_;
  std::vector<CellState> states_;
};

}  // namespace swiftlet::testing
