// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <span>

#include "core/interception/surroundings.hpp"
#include "swiftlet/core/interception/intercept.hpp"

namespace swiftlet {

/// Plans how the vehicle comes to where the target will be. Local frame.
class ChasePlanner {
 public:
  /// @param reach_m  they meet when the target is this near to the middle of the net, in the plane
  ChasePlanner(const ChasePlanConfig& config, const MotionLimits& limits, double reach_m);

  /// @param to_target_local_m  from where the vehicle shall be to where the target is then
  /// @param side               1: the net comes from above the target, -1: from below; 0: from anywhere
  /// @param since_last_s       how long ago the last plan was made
  void plan(const PointState& self, const TargetPrediction& target, const Vector3& to_target_local_m, double side,
            const Surroundings& surroundings, double since_last_s);
  /// The next plan has nothing to do with the last one.
  void forget();
  /// Some time after the plan was made.
  PointState at(double t_s) const { return mpc_.at(t_s); }
  double horizon_s() const { return mpc_.num_steps() * mpc_.step_s(); }
  double time_to_go_s() const { return time_to_go_s_; }
  /// How soon they can meet at the earliest, as far as speed and acceleration tell.
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
  double amid_for_s_ = 0.0;  // the target has been amid the net, in the plane
  bool planned_ = false;
};

}  // namespace swiftlet
