// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/interception/chase_planner.hpp"
#include "core/interception/path_ahead.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// Motion that an interception requires of its vehicle. Local frame.
struct FlightTask {
  enum class Kind { kChase, kLeave, kGoTo };
  Kind kind = Kind::kGoTo;
  const TargetPrediction* target = nullptr;  ///< target of kChase and kLeave
  const Surroundings* surroundings = nullptr;
  Vector3 goal_local_m = Vector3::Zero();  ///< goal of kGoTo
  bool net_to_goal = false;                ///< the net flies to the goal, not the vehicle
};

/// Flies the tasks of an interceptor by the method of its configuration. Any motion is limited to states from which
/// braking keeps clear of all obstacles.
class InterceptFlight {
 public:
  InterceptFlight(const InterceptConfig& config, const GuidanceSetup& setup);

  /// Begins a tick. The reference starts at the first estimate.
  void begin_tick(const StateEstimate& estimate);
  /// @param anew  discards the present plan; the next plan is due at once
  void set_task(const FlightTask& task, bool anew);
  bool is_plan_due() const { return since_plan_s_ >= period_s_; }
  double since_plan_s() const { return since_plan_s_; }
  /// Simulates the motion until the next plan, and brakes instead if the vehicle could not stop in time after it.
  void plan();
  /// Moves the reference by one tick.
  const Reference& step(double dt_s);

  /// Center of the net by the estimate.
  Vector3 net_m() const { return net_.center(p_local_m_, governor_.state().yaw_rad); }
  double yaw_rad() const { return governor_.state().yaw_rad; }
  /// Lower bound of the time until the net meets the target.
  double arrival_s(const TargetPrediction& target) const;
  /// Predicted path of the vehicle from its present plan.
  PathAhead path_ahead();
  const ChasePlanner& planner() const { return planner_; }

 private:
  using Method = InterceptConfig::Method;

  void fly(ReferenceGovernor& governor, double since_s, double ahead_s, double dt_s);
  Reference goal_of_task(const Reference& self);
  Vector3 chase_mps2(const Reference& self, double ahead_s) const;
  Vector3 leave_mps2(const Reference& self) const;
  Vector3 to_target_m(const TargetPrediction& target) const;
  Vector3 passing_m(const PointState& target, const Vector3& offset_local_m) const;
  double side();
  double face(const Vector3& place_local_m);
  PointState state() const;

  Method method_;
  CaptureVolume net_;
  PursuitGains gains_;
  double target_clearance_m_, period_s_;
  MotionLimits limits_;
  ReferenceGovernor governor_;  // flown reference, in the local frame
  ChasePlanner planner_;
  FlightTask task_;
  Vector3 p_local_m_ = Vector3::Zero();
  Vector3 bias_local_m_ = Vector3::Zero();  // difference between estimate and reference
  double yaw_rad_, since_plan_s_, side_ = 1.0;
  bool started_ = false, brakes_ = false;
};

}  // namespace swiftlet
