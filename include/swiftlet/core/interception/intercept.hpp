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
  double horizon_min_s = 1.0;
  double horizon_max_s = 2.5;
  double weight_before = 0.02;
  double weight_after = 0.02;
  double meeting_s = 0.5;
  double velocity_weight = 0.0;
  double hold_m = 0.2;
  double through_m = 0.06;
  double crossing_mps = 1.0;
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
