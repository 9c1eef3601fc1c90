// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "swiftlet/core/guidance/neighbor_memory.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/math/latency.hpp"
#include "swiftlet/core/planning/clear_path.hpp"

namespace swiftlet {

/// How a vehicle gets out of a pocket. Not in the document.
struct RblDetourConfig {
  bool enabled = true;
  double patience_s = 3.0;
  double climb_m = 1.0;
  double planning_latency_s = 0.5;
  double retry_after_s = 2.0;
  int retries = 3;
  ClearPathConfig planner;

  /// A vehicle in a pocket has not seen the way out, and looks for any way rather than for the shortest.
  RblDetourConfig() {
    planner.clearance_m = 0.75;
    planner.unknown_is_free = true;
    planner.greed = 1.5;
    planner.max_expansions = 200'000;
  }
  void visit(ConfigVisitor& v);
};

/// The next goal of a vehicle: the goal itself, until it gets no nearer for a while. From then on it is a point ahead
/// on a path to the goal that is clear in the vehicle's own map. The path is held against every new map. It is planned
/// anew when something stands in it, when the vehicle is off it, and when the vehicle does not get on.
class RblDetour {
 public:
  /// @param ahead_m  how far the next goal lies ahead, at most
  RblDetour(const RblDetourConfig& config, double ahead_m);

  struct Situation {
    Vector3 goal_local_m = Vector3::Zero();
    Vector3 p_local_m = Vector3::Zero();
    double z_min_m = 0.0, z_max_m = 0.0;  ///< of the heights to fly at, in the local frame
    double encumbrance_m = 0.0;           ///< of a neighbor
    bool planar = false;                  ///< it keeps its height
    double sees_goal_from_m = 0.0;        ///< as far beside the goal, at its own height, the goal is in view
    std::span<const Neighbor> neighbors = {};
    const OccupancyView* map = nullptr;  ///< null: the goal is the next goal for ever
    TimeNs now = 0;
  };
  Vector3 next_goal_local_m(const Situation& situation);

  /// A point of the path to fly straight to, since the last call of next_goal_local_m. Cells are convex, so before a
  /// gap between two trunks a vehicle may stand at its own centroid, although the way ahead is clear. Nothing while it
  /// moves, or when the way is not clear. Nor past somebody who stands: its own rules lead around neighbors.
  const std::optional<Vector3>& straight_local_m() const { return straight_local_m_; }

  /// It flies to where it sees its goal, which may be free although its map says otherwise.
  bool is_looking() const { return beside_ && !gave_up(); }
  bool on_path() const { return !corners_local_m_.empty(); }
  const std::vector<Vector3>& corners_local_m() const { return corners_local_m_; }
  /// Why there is no path, or that there is one; empty while the goal itself is flown to.
  const char* note() const { return note_; }
  /// Again and again there was no path.
  bool gave_up() const { return failures_ > config_.retries; }

  std::uint64_t num_plans() const { return num_plans_; }
  std::uint64_t num_given_up() const { return num_given_up_; }

 private:
  bool gets_on(double left_m, TimeNs now);
  void plan(const Situation& situation);
  void take(const Situation& situation);
  void search(const Situation& situation, Vector3 goal_local_m, bool level, bool narrow);
  bool look_from_beside(const Situation& situation);
  bool is_above_or_below(const Situation& situation) const;
  ClearPathConfig rules_for(const Situation& situation, bool level) const;
  bool is_near_goal(const Situation& situation) const;
  bool has_to_plan(const Situation& situation, double left_m);
  double follow(const Vector3& p_local_m);
  Vector3 at_local_m(double arc_m) const;
  Vector3 point_ahead_local_m(const Situation& situation) const;
  bool is_held(const Situation& situation);
  std::optional<Vector3> clear_point_local_m(const Situation& situation, double clearance_m) const;

  RblDetourConfig config_;
  double ahead_m_;
  double least_m_ = std::numeric_limits<double>::infinity();  // that was left so far
  TimeNs since_ = 0, retry_ = 0;
  Worker planner_;
  ClearPath found_;  // what the planner is at work on
  ClearPathConfig rules_;
  std::vector<Vector3> corners_local_m_;
  double arc_m_ = 0.0;                       // along the path, where the vehicle is
  double off_m_ = 0.0;                       // it
  bool beside_ = false;                      // it ends beside the goal, from where it looks
  double beside_m_ = 0.0;                    // as far
  bool level_ = false;                       // the path ends at its own height, not at the goal's
  Vector3 stood_local_m_ = Vector3::Zero();  // where it was when it moved last
  TimeNs stood_ = 0;                         // since then
  double straight_until_m_ = 0.0;            // along the path
  std::optional<Vector3> straight_local_m_;
  std::uint64_t checked_ = 0;
  const char* note_ = "";
  int failures_ = 0;
  std::uint64_t num_plans_ = 0, num_given_up_ = 0;
};

}  // namespace swiftlet
