// SPDX-License-Identifier: BSD-3-Clause
#include "interception_protocol.hpp"

#include <fmt/format.h>

#include <cmath>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kSlowestTarget_mps = 3.0;
constexpr int kFirstTrajectory = 100;                             // the planner is tuned on other trajectories
constexpr double kNearestStart_m = 5.0, kFarthestStart_m = 20.0;  // distance between start and target

}  // namespace

sim::Scenario protocol_flight(const char* method, const TargetLimits& limits, int trajectory, int start) {
  const auto number = static_cast<std::uint32_t>(kFirstTrajectory + trajectory);
  const Random random(1, "interception.protocol");
  const double speed_mps = random.uniform(kSlowestTarget_mps, limits.speed_mps, number, 0);
  const double acceleration_mps2 = limits.acceleration_mps2 * speed_mps / limits.speed_mps;
  const auto index = static_cast<std::uint32_t>(16 * (start + 1));
  const double azimuth_rad = random.uniform(0.0, 2.0 * kPi, number, index);
  const double elevation_rad = random.uniform(-0.5, 0.5, number, index + 1);
  const double distance_m = random.uniform(kNearestStart_m, kFarthestStart_m, number, index + 2);
  const double level_m = distance_m * std::cos(elevation_rad);
  return scenario_with("reproduce/interception.yaml", number + 1,
                       {{"vehicles[0].agent.guidance.method", method},
                        {"vehicles[0].start.position_m",
                         fmt::format("[{:.3f}, {:.3f}, {:.3f}]", level_m * std::cos(azimuth_rad),
                                     level_m * std::sin(azimuth_rad), 25.0 + distance_m * std::sin(elevation_rad))},
                        {"vehicles[1].agent.guidance.seed", std::to_string(number + 1)},
                        {"vehicles[1].agent.guidance.speed_mps", fmt::format("{:.4f}", speed_mps)},
                        {"vehicles[1].agent.guidance.acceleration_mps2", fmt::format("{:.4f}", acceleration_mps2)}});
}

}  // namespace swiftlet::tools
