// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "swiftlet/core/guidance/guide.hpp"

namespace swiftlet {

/// A guided vehicle: its goals, the guide's estimate of it, and its progress.
struct GuidedVehicle {
  VehicleId id = kNoVehicle;
  std::vector<Eigen::Vector3d> goals_world_m;
  std::vector<double> goal_yaws_deg;
  std::optional<RelativeEstimate> estimate;  ///< from this tick's input
  bool known_well = false, linked = false, was_known = false;
  Vector3 last_place_local_m = Vector3::Zero();
  TimeNs last_known = 0;
  std::size_t num_reached = 0;
  std::optional<Vector3> began_local_m;
  double advanced_m = 0.0;

  bool ready() const { return known_well && linked; }
};

/// The guided vehicles: estimates, goals and turns. One vehicle moves, the others hover.
class GuidedTeam {
 public:
  /// Throws std::invalid_argument for an unknown vehicle, and for one that is named twice.
  /// @param config  must outlive this object
  GuidedTeam(const GuideConfig& config, const AgentSetup& setup);

  /// Updates the estimates, and whether the vehicles are linked and known well enough to guide them.
  void update(const GuidanceInput& input);
  std::span<const GuidedVehicle> vehicles() const { return vehicles_; }
  const GuidedVehicle& moving() const { return vehicles_[moving_]; }
  /// Estimate of the moving vehicle; it must exist.
  const RelativeEstimate& there() const { return *moving().estimate; }
  PlannedPose pose() const { return {there().position_m, there().yaw_rad}; }
  /// Present or last known positions of the hovering vehicles.
  std::vector<Vector3> hovering_local_m() const;
  bool all_ready() const;
  bool all_were_known() const;
  /// [m] Radius of the figure that the moving vehicle is requested to fly, so that it can be localized again; 0: none.
  double figure_m() const { return figure_m_; }

  bool has_more_goals() const;
  /// True when the moving vehicle has a goal after the present one.
  bool has_goal_after(const Vector3& goal_local_m) const;
  /// Chooses the next vehicle in turn, goal by goal, so that the team stays together in view of the guide. False if no
  /// vehicle with goals left has an estimate.
  bool choose_next();
  /// As choose_next(), unless the moving vehicle has goals left.
  bool choose() { return has_more_goals(moving()) || choose_next(); }
  PlannedPose take_goal(const FrameChange& to_local);
  /// Goal after the present goal of the moving vehicle.
  PlannedPose goal_after(const PlannedPose& goal, const FrameChange& to_local) const {
    return goal_from(goal, moving().num_reached + 1, to_local);
  }
  /// The moving vehicle has reached its goal.
  void reach();

 private:
  bool advances() const { return config_.advance.step_m.squaredNorm() > 0.0; }
  bool has_more_goals(const GuidedVehicle& vehicle) const;
  PlannedPose goal_from(const PlannedPose& from, std::size_t num_reached, const FrameChange& to_local) const;
  double room_for_figure_m(const GuidanceInput& input) const;

  const GuideConfig& config_;
  std::vector<GuidedVehicle> vehicles_;  // in the order of turns
  std::size_t moving_ = 0;               // index of the moving vehicle
  double figure_m_ = 0.0;
};

}  // namespace swiftlet
