// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "swiftlet/core/planning/free_space.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"

namespace swiftlet::sim {

/// Do walls enclose the place? Level views in eight directions end at walls; one of them may be open, as through a
/// door. Every surface is a wall except ground and plants, which views pass through.
bool is_enclosed(const StaticScene& world, const Vector3& p_world_m);

/// Share of the ground that walls enclose, seen from this height above it.
double enclosed_share(const StaticScene& world, double height_m);

/// Where a sphere can fly between two heights above the ground of a static world, by its truth. Cells are looked at
/// when first asked for and remembered. Not thread-safe.
class FreeSpace : public FreeSpaceView {
 public:
  struct Limits {
    double radius_m = 1.0;      ///< of the sphere
    double height_min_m = 1.0;  ///< of its center above the ground
    double height_max_m = 5.0;
    double border_m = 2.0;  ///< strip along the edge of the world where nobody flies
    double cell_m = 0.5;    ///< of the grid in which paths are searched
    bool indoors = false;   ///< only where walls enclose the place
  };

  FreeSpace(std::shared_ptr<const StaticScene> world, const Limits& limits);

  /// The rectangle in which one may fly.
  const Eigen::AlignedBox2d& area_m() const { return area_m_; }
  /// Of the ground or floor below, crowns and roofs let through; nullopt where there is none [m].
  std::optional<double> ground_m(double x_m, double y_m) const;
  const CellGrid& grid() const override { return grid_; }
  bool is_free(const Vector3& p_world_m) const override;
  bool is_free(const Vector3& p_world_m, double radius_m) const;
  bool is_free_cell(int index) const override;

 private:
  bool is_indoors(const Vector3& p_world_m) const;

  std::shared_ptr<const StaticScene> world_;
  Limits limits_;
  Eigen::AlignedBox2d area_m_;
  CellGrid grid_;
  mutable std::vector<std::uint8_t> free_;     // by cell: 0 not looked at, 1 free, 2 not
  mutable std::vector<float> ground_m_;        // by column: NaN not looked at, infinity none
  mutable std::vector<std::uint8_t> indoors_;  // by cell, as free_; empty when it does not matter
};

}  // namespace swiftlet::sim
