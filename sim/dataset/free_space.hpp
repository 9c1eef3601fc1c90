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

/// True if walls enclose the position. Horizontal rays in eight directions must end at walls, except one, as through a
/// door. All surfaces are walls except ground and plants, which rays pass through.
bool is_enclosed(const StaticScene& world, const Vector3& p_world_m);

/// Share of the ground enclosed by walls, tested at this height above it.
double enclosed_share(const StaticScene& world, double height_m);

/// Free space of a sphere between two heights above the ground of a static world, from the truth. Cells are evaluated
/// on first access and cached. Not thread-safe.
class FreeSpace : public FreeSpaceView {
 public:
  struct Limits {
    double radius_m = 1.0;      ///< radius of the sphere
    double height_min_m = 1.0;  ///< least height of its center above the ground
    double height_max_m = 5.0;
    double border_m = 2.0;  ///< width of the excluded strip along the edge of the world
    double cell_m = 0.5;    ///< cell size of the grid for path search
    bool indoors = false;   ///< only positions enclosed by walls
  };

  FreeSpace(std::shared_ptr<const StaticScene> world, const Limits& limits);

  /// Permitted rectangle.
  const Eigen::AlignedBox2d& area_m() const { return area_m_; }
  /// Height of the ground or floor below, ignoring crowns and roofs; nullopt without ground [m].
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
  mutable std::vector<std::uint8_t> free_;     // per cell: 0 not evaluated, 1 free, 2 occupied
  mutable std::vector<float> ground_m_;        // per column: NaN not evaluated, infinity without ground
  mutable std::vector<std::uint8_t> indoors_;  // per cell, as free_; empty unless Limits::indoors
};

}  // namespace swiftlet::sim
