// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/guidance/separation/neighbor_memory.hpp"
#include "swiftlet/core/guidance/rbl_config.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/math/latency.hpp"
#include "swiftlet/core/planning/clear_path.hpp"

namespace swiftlet {

/// Provides the next goal of a vehicle: the goal itself until progress stalls, then a point ahead on a path to the goal
/// that is clear in the vehicle's own map. The path is checked against every map revision. It is replanned when it is
/// blocked, when the vehicle is off the path, and when progress stalls.
class RblDetour {
 public:
  /// @param ahead_m  maximum distance of the next goal along the path
  RblDetour(const RblDetourConfig& config, double ahead_m);

  struct Situation {
    Vector3 goal_local_m = Vector3::Zero();
    Vector3 p_local_m = Vector3::Zero();
    double z_min_m = 0.0, z_max_m = 0.0;  ///< allowed flight heights, in the local frame
    double encumbrance_m = 0.0;           ///< radius of the sphere that a vehicle occupies
    bool planar = false;                  ///< the vehicle keeps its height
    double sees_goal_from_m = 0.0;        ///< horizontal distance from which the goal is in view at the own height
    std::span<const Neighbor> neighbors = {};
    const OccupancyView* map = nullptr;  ///< null: the detour is disabled
    TimeNs now = 0;
  };
  Vector3 next_goal_local_m(const Situation& situation);

  /// A point of the path that may be flown to in a straight line, as of the last call of next_goal_local_m. Cells are
  /// convex, so a vehicle may rest at its own centroid before a gap between two trunks although the path is clear.
  /// Empty while the vehicle moves, when the line is not clear, or when a stationary neighbor is on it: the cell rules
  /// lead around neighbors.
  const std::optional<Vector3>& straight_local_m() const { return straight_local_m_; }

  /// The path ends at a viewpoint of the goal, which may be free although the map shows it occupied.
  bool is_looking() const { return to_viewpoint_ && !has_failed(); }
  bool on_path() const { return !corners_local_m_.empty(); }
  const std::vector<Vector3>& corners_local_m() const { return corners_local_m_; }
  /// Note for the mission status: on a detour, or the reason for which no path was found; empty on the direct path.
  const char* note() const { return note_; }
  /// The number of consecutive failed plans exceeds the retries.
  bool has_failed() const { return failures_ > config_.retries; }

  std::uint64_t num_plans() const { return num_plans_; }
  std::uint64_t num_given_up() const { return num_given_up_; }

 private:
  bool makes_progress(double remaining_m, TimeNs now);
  void plan(const Situation& situation);
  void take(const Situation& situation);
  void search(const Situation& situation, Vector3 goal_local_m, bool level, bool narrow);
  bool plan_viewpoint(const Situation& situation);
  bool is_above_or_below(const Situation& situation) const;
  ClearPathConfig rules_for(const Situation& situation, bool level) const;
  bool is_near_goal(const Situation& situation) const;
  bool needs_plan(const Situation& situation, double remaining_m);
  double follow(const Vector3& p_local_m);
  Vector3 at_local_m(double arc_m) const;
  Vector3 point_ahead_local_m(const Situation& situation) const;
  bool is_held(const Situation& situation);
  std::optional<Vector3> clear_point_local_m(const Situation& situation, double clearance_m) const;

  RblDetourConfig config_;
  double ahead_m_;
  double least_remaining_m_ = std::numeric_limits<double>::infinity();  // smallest remaining distance so far
  TimeNs progress_at_ = 0, retry_at_ = 0;
  Worker planner_;
  ClearPath found_;  // result of the plan in progress
  ClearPathConfig rules_;
  std::vector<Vector3> corners_local_m_;
  double arc_m_ = 0.0;                            // position of the vehicle along the path
  double off_m_ = 0.0;                            // distance of the vehicle from the path
  bool to_viewpoint_ = false;                     // the path ends at a viewpoint beside the goal
  double viewpoint_m_ = 0.0;                      // horizontal distance of the viewpoint from the goal
  bool level_ = false;                            // the path ends at the vehicle's height, not at the goal's
  Vector3 last_moved_local_m_ = Vector3::Zero();  // position when the vehicle moved last
  TimeNs last_moved_at_ = 0;                      // time when the vehicle moved last
  double straight_until_m_ = 0.0;                 // position along the path up to which straight flight is kept
  std::optional<Vector3> straight_local_m_;
  std::uint64_t checked_revision_ = 0;
  const char* note_ = "";
  int failures_ = 0;
  std::uint64_t num_plans_ = 0, num_given_up_ = 0;
};

}  // namespace swiftlet
