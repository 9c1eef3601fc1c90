// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <optional>
#include <utility>

#include "core/guidance/heading.hpp"
#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {

/// Guidance along an endless trajectory that is generated during the run. `Flight` generates it in the world frame:
/// `Flight(config, start_m, vertical_speed_mps, vertical_acceleration_mps2)`, `advance(dt_s)`, `reference()`. The
/// trajectory begins at the vehicle's start. The heading follows the velocity unless a fixed heading is given.
template <typename Config, typename Flight>
class EndlessFlight : public Guidance {
 public:
  EndlessFlight(Config config, const GuidanceSetup& setup, std::optional<double> yaw_world_rad = std::nullopt)
      : config_(std::move(config)),
        limits_(setup.limits),
        yaw_world_rad_(yaw_world_rad),
        start_local_m_(setup.agent.T_local_body_start.translation()),
        yaw_rad_(yaw_of(setup.agent.T_local_body_start.linear())) {}

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    if (!flight_) {  // begins at the start position, transformed by the present correction
      flight_.emplace(config_, FrameChange::to_world(input.estimate).point(start_local_m_), limits_.vertical_speed_mps,
                      limits_.vertical_acceleration_mps2);
    }
    flight_->advance(input.dt_s);
    const FrameChange to_local = FrameChange::to_local(input.estimate);
    output.goal = to_local.reference(flight_->reference());
    if (yaw_world_rad_)
      yaw_rad_ = to_local.yaw(*yaw_world_rad_);
    else
      turn_along_velocity(kMinHeadingSpeed_mps, yaw_rad_, output.goal);
    double& rate_radps = output.goal.yaw_rate_radps;
    rate_radps = std::clamp(rate_radps, -limits_.heading_rate_radps, limits_.heading_rate_radps);
    output.goal.yaw_rad = yaw_rad_;
    output.mission = MissionStatus::kEndless;
  }

 private:
  /// [m/s] Horizontal speed below which the heading is kept. Smaller values may turn a nearly hovering vehicle
  /// abruptly.
  static constexpr double kMinHeadingSpeed_mps = 0.5;

  Config config_;
  MotionLimits limits_;
  std::optional<double> yaw_world_rad_;  // fixed heading; empty: along the velocity
  Vector3 start_local_m_;
  std::optional<Flight> flight_;  // in the world
  double yaw_rad_;                // in the local frame
};

}  // namespace swiftlet
