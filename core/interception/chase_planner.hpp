// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <span>

#include "core/interception/chase_mpc.hpp"
#include "core/interception/surroundings.hpp"
#include "core/interception/target_prediction.hpp"
#include "swiftlet/core/interception/intercept.hpp"

namespace swiftlet {

/// Plans the motion of the vehicle to the predicted target. Local frame.
class ChasePlanner {
 public:
  /// @param reach_m  horizontal distance of the target from the net's center within which they meet
  ChasePlanner(const ChasePlanConfig& config, const MotionLimits& limits, double reach_m);

  /// @param to_target_local_m  displacement from the vehicle's goal to the target at that time
  /// @param side               1: the net comes from above the target, -1: from below; 0: from anywhere
  /// @param since_last_s       time since the last plan
  void plan(const PointState& self, const TargetPrediction& target, const Vector3& to_target_local_m, double side,
            const Surroundings& surroundings, double since_last_s);
  /// Discards the last plan: the next one starts cold.
  void forget();
  /// State of the plan at a time after it was made.
  PointState at(double t_s) const { return mpc_.at(t_s); }
  double horizon_s() const { return mpc_.num_steps() * mpc_.step_s(); }
  double time_to_go_s() const { return time_to_go_s_; }
  /// Lower bound of the time to the meeting, by speed and acceleration.
  double least_time_s(const PointState& self, const TargetPrediction& target, const Vector3& to_target_local_m) const;

 private:
  std::optional<double> crossing_s(const TargetPrediction& target, const Vector3& to_target_local_m,
                                   double since_last_s);

  ChasePlanConfig config_;
  MotionLimits limits_;
  double reach_m_;
  ChaseMpc mpc_;
  std::array<ChaseAim, ChaseMpc::kMaxSteps> aims_;
  double time_to_go_s_ = 0.0;
  double amid_for_s_ = 0.0;  // time for which the target has been within reach in the plane
  bool planned_ = false;
};

}  // namespace swiftlet
