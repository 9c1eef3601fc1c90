// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/core/base/capture_volume.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

struct ChaseMpcConfig {
  int iterations = 80;         ///< [-] largest number of iterations of the solver; larger values cost time
  double tolerance = 1e-3;     ///< [-] violation of the limits, as a share of them, at which the solver stops
  double jerk_weight = 1e-3;   ///< [m^2] cost of full jerk, as a squared distance
  double wall_weight = 200.0;  ///< [1/m^2] weight of squared distances beyond a wall
};

/// Flight area of an interceptor: a box in the world, and the waiting time for a target that has left it.
struct GeofenceConfig {
  Eigen::Vector3d min_m = {-100.0, -100.0, 2.0};
  Eigen::Vector3d max_m = {100.0, 100.0, 50.0};
  double patience_s = 2.0;

  void visit(ConfigVisitor& v);
};

/// Gains of the guidance laws that serve as baselines.
struct PursuitGains {
  double pure_pursuit = 1.0;
  double proportional_navigation = 3.0;
  double frpn = 19.7;
  double frpn_weight = 0.051;      ///< [-] W of FRPN: share of pure pursuit
  double time_to_go_min_s = 0.05;  ///< [s] lower bound of the time to go
  double time_to_go_max_s = 30.0;  ///< [s] upper bound of the time to go

  void visit(ConfigVisitor& v);
};

struct TargetPredictionConfig {
  double acceleration_time_s = 0.8;
  double speed_max_mps = 15.0;

  void visit(ConfigVisitor& v);
};

/// Search for a lost target.
struct TargetSearchConfig {
  double timeout_s = 20.0;
  double acceleration_mps2 = 2.0;
  double speed_max_mps = 8.0;
  double range_m = 20.0;
  double fov_bottom_deg = -22.5;
  double fov_top_deg = 22.5;
  double detection_rate_per_s = 3.0;  ///< [1/s] rate of detections of a visible target

  void visit(ConfigVisitor& v);
};

/// Settings of the planner for `method: mpc`.
struct ChasePlanConfig {
  int steps = 20;
  double horizon_min_s = 1.0;   ///< [s] shortest horizon of the plan
  double horizon_max_s = 2.5;   ///< [s] longest horizon; between both, 1.3 times the time to go
  double weight_before = 0.02;  ///< [-] weight of squared distances before the meeting; 1: as at the meeting
  /// [-] weight after the meeting; at 1 the vehicle stays with the target, and arrives later
  double weight_after = 0.02;
  double reach_share = 0.48;
  double velocity_weight = 0.0;  ///< [s^2] weight of the squared difference of velocities at the meeting
  double hold_m = 0.2;           ///< [m] vertical distance that a disc keeps from the target until they meet
  double through_m = 0.06;       ///< [m] vertical distance by which a disc then passes the target
  double crossing_mps = 1.0;     ///< [m/s] vertical speed at which a disc crosses the target's height
  /// [s] delay from the target within reach to the crossing; less if the target would be out of reach by then
  double crossing_delay_s = 0.15;
  ChaseMpcConfig solver;

  void visit(ConfigVisitor& v);
};

/// Interception of a tracked flying target [Vrba 2025, sec. VI-B]: predicts the target and flies so that it enters the
/// net as soon as the motion limits allow.
///
/// A lost target is searched at its possible positions. The pursuit ends at the fence. For any method, motion is
/// limited to states from which braking keeps clear of the ground, of mapped obstacles, and of all other vehicles.
struct InterceptConfig : ModuleConfigOf<InterceptConfig> {
  enum class Method { kMpc, kFrpn, kProportionalNavigation, kPurePursuit };
  Method method = Method::kMpc;
  std::string target;
  int captures = 1;
  CaptureVolume net;
  GeofenceConfig fence;
  enum class Walls { kNone, kMap };
  Walls walls = Walls::kNone;
  double clearance_m = 1.5;
  double target_clearance_m = 1.0;
  double bystander_clearance_m = 3.0;
  double yield_clearance_m = 6.0;
  double period_s = 0.05;
  ChasePlanConfig plan;
  TargetPredictionConfig prediction;
  PursuitGains gains;
  TargetSearchConfig search;

  void visit(ConfigVisitor& v) override;
};

}  // namespace swiftlet
