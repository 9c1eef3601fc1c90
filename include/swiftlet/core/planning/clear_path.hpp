// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// Path search in a map. The budget is counted in cells, never in time, so results do not depend on the machine.
struct ClearPathConfig {
  double clearance_m = 0.8;
  bool unknown_is_free = false;
  double z_min_m = -1e5;
  double z_max_m = 1e5;
  /// [-] weight of the remaining distance; above 1 the search is faster and the path longer by at most that factor
  double heuristic_weight = 1.0;
  int max_expansions = 300'000;
  int max_shortenings = 5;  ///< [-] largest number of passes that cut corners

  void visit(ConfigVisitor& v);
  void visit_limits(ConfigVisitor& v);  ///< clearance and heights only
};

enum class ClearPathStatus { kFound, kStartEnclosed, kGoalBlocked, kGoalUnknown, kGoalTooFar, kNoPath, kBudgetSpent };
/// True when the position is within the range of cell indices, a million along each axis.
bool is_on_map(const Vector3& p_local_m, double edge_m);
/// Text of the status, for an event.
const char* text_of(ClearPathStatus status);

/// A path, or the reason why there is none.
struct ClearPath {
  ClearPathStatus status = ClearPathStatus::kNoPath;
  std::vector<Vector3> corners_local_m;  ///< from the start to the goal; empty when there is none
  std::size_t expansions = 0;            ///< number of expanded cells
};

/// Admissible space of a vehicle: cells whose center has more than the clearance, within the height limits, and known
/// if required. A start nearer to an obstacle, or in unknown space, is left within a ball around it, in which a cell is
/// admissible when it is not occupied and no nearer to obstacles than the start.
class ClearSpace {
 public:
  /// Heights are in the local frame. The view must outlive this object.
  ClearSpace(const OccupancyView& view, const ClearPathConfig& config, const Vector3& start_local_m);
  bool is_clear(const Vector3& p_local_m) const;
  /// True when every cell on the segment is clear.
  bool is_clear_segment(const Vector3& from_local_m, const Vector3& to_local_m) const;
  bool near_start(const Vector3& p_local_m) const {
    return (p_local_m - start_local_m_).squaredNorm() <= relaxed_m_ * relaxed_m_;
  }

 private:
  const OccupancyView& view_;
  double clearance_m_, z_min_m_, z_max_m_;
  bool unknown_is_free_;
  Vector3 start_local_m_;
  double start_clearance_m_;
  double relaxed_m_;  // radius of the ball; 0: the start is clear
};

/// Reason for which no path can exist, determined without a search; kFound when a path may exist.
ClearPathStatus refusal_reason(const OccupancyView& view, const ClearSpace& space, const ClearPathConfig& config,
                               const Vector3& start_local_m, const Vector3& goal_local_m);

/// A short path with clearance [Kratky 2021, the planner that Pritzl 2024 uses]. A* over the 26 neighbors of a cell,
/// followed by repeated shortcuts from both ends along clear straight lines. A pure function: equal views give equal
/// paths.
ClearPath find_clear_path(const OccupancyView& view, const ClearPathConfig& config, const Vector3& start_local_m,
                          const Vector3& goal_local_m);

/// Shortens a clear path by shortcuts, from the start, then from the end, and so on, while its length decreases.
std::vector<Vector3> shortened_path(const ClearSpace& space, std::vector<Vector3> path_local_m, int times);

/// Rules with a clearance smaller by one cell edge, so that obstacle cells that change at random do not invalidate a
/// path.
ClearPathConfig narrowed(const ClearPathConfig& config, double edge_m);

/// True when the map has changed so that the rest of a path is not clear any more by the narrowed rules.
/// @param p_local_m     position of the vehicle
/// @param next          index of the next corner; the vehicle is between the previous one and this
bool is_blocked(const OccupancyView& view, const ClearPathConfig& config, const Vector3& p_local_m,
                std::span<const Vector3> corners_local_m, std::size_t next = 1);

double length_m(const std::vector<Vector3>& corners_local_m);

}  // namespace swiftlet
