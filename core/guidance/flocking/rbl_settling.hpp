// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <span>

#include "core/guidance/separation/neighbor_memory.hpp"
#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// Mission status of the flight to the goal.
struct RblStatus {
  MissionStatus mission = MissionStatus::kRunning;
  const char* note = "";
};

/// Goal and its surroundings.
struct RblGoal {
  Vector3 p_local_m = Vector3::Zero();
  double z_min_m = 0.0, z_max_m = 0.0;  ///< allowed flight heights, in the local frame
  double reach_m = 0.0;                 ///< distance within which the surroundings of the goal are known
  double encumbrance_m = 0.0;
  double apart_m = 0.0;  ///< distance that vehicles keep; a neighbor closer to the goal than this occupies it
  bool planar = false;   ///< heights are ignored
};

/// Detects vehicles that cannot reach their goal. After patience_s without progress, the known reason is reported. The
/// mission is done when other vehicles are at the goal. It has failed when an obstacle is there, or when the goal is
/// outside of the limits. The report stands until progress resumes, even if the others move.
class RblSettling {
 public:
  /// @param patience_s  time without progress before a report; 0: no reports
  explicit RblSettling(double patience_s) : patience_s_(patience_s) {}

  RblStatus update(const RblGoal& goal, const Vector3& p_local_m, std::span<const Neighbor> neighbors,
                   const OccupancyView* map, TimeNs now);

 private:
  static RblStatus reason(const RblGoal& goal, const Vector3& p_local_m, std::span<const Neighbor> neighbors,
                          const OccupancyView* map);

  double patience_s_;
  RblStatus reported_;
  double least_m_ = std::numeric_limits<double>::infinity();  // smallest distance to the goal so far
  TimeNs since_ = 0;
};

}  // namespace swiftlet
