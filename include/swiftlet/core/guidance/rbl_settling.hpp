// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <span>

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/guidance/neighbor_memory.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// What a vehicle says of its way to the goal.
struct RblStatus {
  MissionStatus mission = MissionStatus::kRunning;
  const char* note = "";
};

/// Where the goal lies, and what is there.
struct RblGoal {
  Vector3 p_local_m = Vector3::Zero();
  double z_min_m = 0.0, z_max_m = 0.0;  ///< of the heights that the vehicle may fly at, in the local frame
  double reach_m = 0.0;                 ///< nearer than this, what is at the goal is known
  double encumbrance_m = 0.0;
  double apart_m = 0.0;  ///< that two vehicles keep: one nearer to the goal than this leaves no room there
  bool planar = false;   ///< the height does not count
};

/// Tells a vehicle that cannot reach its goal from one that is on its way. One that got no nearer for a while says
/// why, when it is known. It is done when others are at the goal. It has failed when an obstacle is there, or when the
/// goal lies out of the limits. What was said stands until it gets nearer, although the others move.
class RblSettling {
 public:
  /// @param patience_s  0: never says so
  explicit RblSettling(double patience_s) : patience_s_(patience_s) {}

  RblStatus update(const RblGoal& goal, const Vector3& p_local_m, std::span<const Neighbor> neighbors,
                   const OccupancyView* map, TimeNs now);

 private:
  static RblStatus reason(const RblGoal& goal, const Vector3& p_local_m, std::span<const Neighbor> neighbors,
                          const OccupancyView* map);

  double patience_s_;
  RblStatus told_;
  double least_m_ = std::numeric_limits<double>::infinity();  // distance to the goal so far
  TimeNs since_ = 0;
};

}  // namespace swiftlet
