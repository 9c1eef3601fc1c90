// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// How a path is searched through a map. The budget is counted in cells, never in time, so the result is the same on
/// any machine.
struct ClearPathConfig {
  double clearance_m = 0.8;
  bool unknown_is_free = false;
  double z_min_m = -1e5;
  double z_max_m = 1e5;
  double greed = 1.0;
  int max_expansions = 300'000;
  int max_shortenings = 5;

  void visit(ConfigVisitor& v);
};

enum class ClearPathStatus { kFound, kStartEnclosed, kGoalBlocked, kGoalUnknown, kGoalTooFar, kNoPath, kBudgetSpent };
/// Can a map have a cell there? It counts cells up to a million along each axis.
bool is_on_map(const Vector3& p_local_m, double edge_m);
/// Why there is no path, for an event.
const char* text_of(ClearPathStatus status);

/// A path, or the reason why there is none.
struct ClearPath {
  ClearPathStatus status = ClearPathStatus::kNoPath;
  std::vector<Vector3> corners_local_m;  ///< from the start to the goal; empty when there is none
  std::size_t expansions = 0;            ///< cells that were looked at in depth
};

/// Where a vehicle may be: in cells whose center has more than the clearance, within the limits of height. When that is
/// asked for, they must be known. A start that lies nearer to an obstacle than that, or in unknown space, is left
/// through a ball around it. There every cell counts that is not occupied and no nearer to obstacles than the start is.
class ClearSpace {
 public:
  /// Heights are those of the local frame. The view must outlive it.
  ClearSpace(const OccupancyView& view, const ClearPathConfig& config, const Vector3& start_local_m);
  bool is_clear(const Vector3& p_local_m) const;
  /// Every cell on the segment.
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

/// Why there can be no path, told without a search; kFound when there may be one.
ClearPathStatus why_refused(const OccupancyView& view, const ClearSpace& space, const ClearPathConfig& config,
                            const Vector3& start_local_m, const Vector3& goal_local_m);

/// A short path with clearance [Kratky 2021, the planner that Pritzl 2024 uses]. A* searches the 26 neighbors of a
/// cell. Then corners are cut where the straight way is clear, again and again from both ends. A pure function: the
/// same view gives the same path.
ClearPath find_clear_path(const OccupancyView& view, const ClearPathConfig& config, const Vector3& start_local_m,
                          const Vector3& goal_local_m);

/// A clear path with its corners cut: from the beginning, then from the end, and so on, as long as it gets shorter.
std::vector<Vector3> shortened_path(const ClearSpace& space, std::vector<Vector3> path_local_m, int times);

/// Has the map changed so that what is left of a path is not clear any more? Asked with a cell's edge less of clearance
/// than it was planned with: an obstacle whose cells flicker makes no other path.
/// @param p_local_m     where the vehicle is
/// @param next          of the corners, the next one; from the one before the vehicle is on its way
bool is_blocked(const OccupancyView& view, const ClearPathConfig& config, const Vector3& p_local_m,
                std::span<const Vector3> corners_local_m, std::size_t next = 1);

double length_m(const std::vector<Vector3>& corners_local_m);

}  // namespace swiftlet
