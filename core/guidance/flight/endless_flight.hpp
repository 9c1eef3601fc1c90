// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <optional>
#include <utility>

#include "core/guidance/heading.hpp"
#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {

/// Guidance along a flight that is generated during the run: `Flight(config, start_m, vertical_speed_mps,
/// vertical_acceleration_mps2)`, `advance(dt_s)`, `reference()`, all in the world. It begins at the vehicle's start,
/// and its heading follows the velocity unless one is given.
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
    if (!flight_) {  // begins at the start's position in the world, as known now
      flight_.emplace(config_, FrameChange::to_world(input.estimate).point(start_local_m_), limits_.vertical_speed_mps,
                      limits_.vertical_acceleration_mps2);
    }
    flight_->advance(input.dt_s);
    const FrameChange to_local = FrameChange::to_local(input.estimate);
    output.goal = to_local.reference(flight_->reference());
    if (yaw_world_rad_)
      yaw_rad_ = to_local.yaw(*yaw_world_rad_);
    else
      turn_along_velocity(kSlowest_mps, yaw_rad_, output.goal);
    double& rate_radps = output.goal.yaw_rate_radps;
    rate_radps = std::clamp(rate_radps, -limits_.heading_rate_radps, limits_.heading_rate_radps);
    output.goal.yaw_rad = yaw_rad_;
    output.mission = MissionStatus::kEndless;
  }

 private:
  /// [m/s] slowest velocity that gives a heading. Smaller values turn a nearly resting vehicle about.
  static constexpr double kSlowest_mps = 0.5;

  Config config_;
  MotionLimits limits_;
  std::optional<double> yaw_world_rad_;
  Vector3 start_local_m_;
  std::optional<Flight> flight_;  // in the world
  double yaw_rad_;                // in the local frame
};

}  // namespace swiftlet
