// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/guidance/flocking/rbl_planner.hpp"
#include "swiftlet/core/base/overlay.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// Cells, centroids and destination of the last update, for pictures. Overlays without a color take the vehicle's.
void append_rbl_overlays(const RblPlanner& planner, const RblPlanner::Step& step, const Vector3& goal_local_m,
                         std::vector<Overlay>& overlays);

/// Occupied voxels around the vehicle.
void append_rbl_voxels(const OccupancyView& map, const Vector3& p_local_m, std::vector<Overlay>& overlays);

}  // namespace swiftlet
