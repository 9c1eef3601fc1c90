// SPDX-License-Identifier: BSD-3-Clause
#include "rbl_prediction.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/guidance/waypoints.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kFollowing_m = 0.1;    // how far a vehicle is off its reference
constexpr double kSeldom_sigmas = 3.5;  // one sample in 4000 is farther off
constexpr double kSamples = 2.0;        // tell where somebody flies

}  // namespace

RblConditions conditions_of(const sim::Scenario& scenario) {
  RblConditions conditions;
  bool found = false;
  for (const sim::VehicleConfig& vehicle : scenario.vehicles) {
    const StackConfig& stack = vehicle.agent.as<StackConfig>();
    if (stack.guidance.type == "waypoints") {
      const WaypointsConfig& way = stack.guidance.as<WaypointsConfig>();
      const bool comes = way.speed_mps * scenario.duration_s > vehicle.start.position_m.head<2>().norm();
      if (comes) conditions.intruder_mps = std::max(conditions.intruder_mps, way.speed_mps);
    }
    if (found || stack.guidance.type != "rbl") continue;
    found = true;
    const RblConfig& rbl = stack.guidance.as<RblConfig>();
    const sim::NeighborsConfig& see = vehicle.sensors.at(0).as<sim::NeighborsConfig>();
    const MotionLimits limits = rbl.separation.within(stack.control.limits.resolve());
    conditions.encumbrance_m = rbl.cells.encumbrance_m;
    conditions.margin_m = rbl.separation.margin_m;
    conditions.sigmas = rbl.separation.sigmas;
    conditions.speed_mps = std::min(rbl.speed_mps, limits.horizontal_speed_mps);
    conditions.acceleration_mps2 = limits.horizontal_acceleration_mps2;
    conditions.reaction_s = rbl.separation.reaction_s + 1.0 / rbl.update_rate_hz;
    conditions.latency_s = see.latency_s;
    conditions.rate_hz = see.rate_hz;
    conditions.noise = see.ideal ? 0.0 : see.sigma_range_relative;
    conditions.range_m = see.range_max_m;
    conditions.all_around =
        see.ideal || see.cameras.empty() ||
        std::any_of(see.cameras.begin(), see.cameras.end(), [](const auto& camera) { return camera.fov_deg >= 360.0; });
  }
  if (!found)
    throw std::invalid_argument("conditions_of: scenario '" + scenario.name + "' has nobody who flies by rbl");
  return conditions;
}

double way_from_rest_m(double time_s, double speed_mps, double acceleration_mps2) {
  const double faster_s = std::clamp(time_s, 0.0, speed_mps / acceleration_mps2);
  return 0.5 * acceleration_mps2 * faster_s * faster_s + speed_mps * std::max(0.0, time_s - faster_s);
}

double needed_warning_s(const RblConditions& c) {
  const double kept_m = 2.0 * c.encumbrance_m + c.margin_m;
  const double faster_m = 0.5 * c.speed_mps * c.speed_mps / c.acceleration_mps2;  // the way to its speed
  const double aside_s = kept_m < faster_m ? std::sqrt(2.0 * kept_m / c.acceleration_mps2)
                                           : c.speed_mps / c.acceleration_mps2 + (kept_m - faster_m) / c.speed_mps;
  return kSamples / c.rate_hz + c.latency_s + c.reaction_s + aside_s;
}

double predicted_distance_m(const RblConditions& c) {
  const double kept_m = 2.0 * c.encumbrance_m + c.margin_m;
  const double nearer_m = 0.5 * std::max(0.0, kSeldom_sigmas - c.sigmas) * c.noise * kept_m;
  const double among_m = std::max(0.0, kept_m - 2.0 * kFollowing_m - nearer_m);
  if (c.intruder_mps <= 0.0) return among_m;
  if (!c.all_around) return 0.0;
  const double left_s = (c.range_m - kept_m) / c.intruder_mps - kSamples / c.rate_hz - c.latency_s - c.reaction_s;
  return std::min(among_m, way_from_rest_m(left_s, c.speed_mps, c.acceleration_mps2));
}

}  // namespace swiftlet::tools
