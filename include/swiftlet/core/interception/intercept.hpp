// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "swiftlet/core/capture_volume.hpp"
#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/interception/chase_mpc.hpp"
#include "swiftlet/core/interception/geofence.hpp"
#include "swiftlet/core/interception/pursuit_laws.hpp"
#include "swiftlet/core/interception/target_prediction.hpp"
#include "swiftlet/core/interception/target_search.hpp"

namespace swiftlet {

/// Settings of the planner for `method: mpc`.
struct ChasePlanConfig {
  int steps = 20;
  double horizon_min_s = 1.0;   ///< [s] shortest horizon of the plan
  double horizon_max_s = 2.5;   ///< [s] longest horizon; between both, 1.3 times the time to go
  double weight_before = 0.02;  ///< [-] weight of squared distances before the meeting, relative to 1 at it
  /// [-] weight after the meeting; at 1 the vehicle stays with the target, and arrives later
  double weight_after = 0.02;
  double meeting_s = 0.5;
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
/// A lost target is searched where it can be by now. The pursuit ends at the fence. For any method, motion is limited
/// to states from which braking keeps clear of the ground, of mapped obstacles, and of all other vehicles.
struct InterceptConfig : ModuleConfigOf<InterceptConfig> {
  enum class Method { kMpc, kFrpn, kProportionalNavigation, kPurePursuit };
  Method method = Method::kMpc;
  std::string target;
  int captures = 1;
  CaptureVolume net;
  double sure_share = 0.6;
  GeofenceConfig fence;
  enum class Walls { kNone, kMap };
  Walls walls = Walls::kNone;
  double clearance_m = 1.5;
  double target_clearance_m = 1.0;
  double bystander_clearance_m = 3.0;
  double yield_clearance_m = 6.0;
  double period_s = 0.05;
  double track_timeout_s = 1.0;
  double after_capture_s = 2.0;
  ChasePlanConfig plan;
  TargetPredictionConfig prediction;
  PursuitGains gains;
  TargetSearchConfig search;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_intercept(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
