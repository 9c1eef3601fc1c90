// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// A hall with pallet racks in double rows along x, aisles between them, and a cross aisle at either end. Pillars stand
/// at the ends of the rows. Retro-reflective tape marks the floor and the uprights. The leaves of a gate in the east
/// wall (+x) leave a door opening in its middle, of configurable width [Pritzl 2024, sec. III-C] (1.2 m down to 0.9 m).
/// The load of the racks is drawn from the seed; walls, aisles, pillars and door are the same for every seed.
struct WarehouseConfig : ModuleConfigOf<WarehouseConfig> {
  Eigen::Vector3d size_m = {40.0, 26.0, 9.0};
  bool roof = true;
  double aisle_width_m = 3.2;
  double rack_depth_m = 1.1;
  double bay_width_m = 2.8;
  int levels = 4;
  double level_height_m = 1.6;
  double fill = 0.7;
  double gate_width_m = 4.0;
  double gate_height_m = 4.0;
  double door_width_m = 1.2;
  double door_height_m = 2.5;
  bool tape = true;

  void visit(ConfigVisitor& v) override;

  /// Positions of racks and aisles, for generators and path planning.
  int num_double_rows() const;
  double aisle_width() const;                ///< actual width: at least aisle_width_m
  double aisle_center_y_m(int aisle) const;  ///< aisle = 0 ... num_double_rows()
  double row_center_y_m(int row) const;      ///< middle of a double row
  int num_bays() const;
};

Scene make_warehouse(const WarehouseConfig& config, std::uint64_t seed);

}  // namespace swiftlet::sim
