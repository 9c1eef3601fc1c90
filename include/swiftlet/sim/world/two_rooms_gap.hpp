// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Two rooms joined by a gap [Pritzl 2024, sec. III-A]. The gap's center lies at `position_m`, and the path through it
/// runs along the building's x axis. The building can be rotated relative to the world and thus to map grids. The paper
/// gives the gap's width (eq. 1: w_G = 2 d_S + 1.5 resolution) but no other size of the rooms.
struct TwoRoomsGapConfig : ModuleConfigOf<TwoRoomsGapConfig> {
  double gap_width_m = 0.0;
  double safe_distance_m = 0.8;
  double map_resolution_m = 0.1;
  double gap_height_m = 0.0;
  double gap_offset_m = 0.0;
  Eigen::Vector2d room_size_m = {9.0, 10.0};
  double height_m = 4.0;
  double yaw_deg = 0.0;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();

  void visit(ConfigVisitor& v) override;
  double gap_width() const;  ///< the configured width, or eq. 1 [m]
};

Scene make_two_rooms_gap(const TwoRoomsGapConfig& config, std::uint64_t seed);

}  // namespace swiftlet::sim
