// SPDX-License-Identifier: BSD-3-Clause
#include "rbl_prediction.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/guidance/rbl_separation.hpp"
#include "swiftlet/core/guidance/waypoints.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kFollowing_m = 0.1;    // largest tracking error of a vehicle
constexpr double kSeldom_sigmas = 3.5;  // exceeded by one sample in 4000
constexpr double kSamples = 2.0;        // fewest for a velocity estimate
constexpr double kKnownShare = 0.25;    // relative accuracy at which a speed counts as known
constexpr double kLost = 1.0;           // allowance for a lost sample
constexpr double kTold_sigmas = 0.5;    // speed from which an intruder is recognized, in sigmas of the speed prediction

double kept_m(const RblConditions& c) { return 2.0 * c.encumbrance_m + c.margin_m; }

double among_themselves_m(const RblConditions& c) {
  const double nearer_m = 0.5 * std::max(0.0, kSeldom_sigmas - c.sigmas) * c.noise * kept_m(c);
  return std::max(0.0, kept_m(c) - 2.0 * kFollowing_m - nearer_m);
}

/// Speed of the vehicle itself with no known neighbor ahead.
double own_speed_mps(const RblConditions& c) {
  const double unknown_s = 1.0 / c.rate_hz + c.latency_s + c.reaction_s;
  return std::min(c.speed_mps, speed_into_unknown_mps(c.range_m, unknown_s, kept_m(c), c.acceleration_mps2));
}

double aside_m(const RblConditions& c) {
  if (c.intruder_mps <= kTold_sigmas * c.maneuver_mps2 / c.rate_hz) return 0.0;
  const double meets_s = (c.range_m - kept_m(c)) / (c.intruder_mps + own_speed_mps(c));
  const double left_s = meets_s - known_after_s(c) - c.latency_s - c.reaction_s;
  return way_from_rest_m(left_s, c.speed_mps, c.acceleration_mps2);
}

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
    conditions.maneuver_mps2 = rbl.neighbors.acceleration_sigma_mps2;
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

// A line through n samples at rate f with noise sigma has a slope with the standard deviation sigma f sqrt(12 / n^3).
double known_after_s(const RblConditions& c) {
  const double sigma_m = c.noise * c.range_m;
  const double samples = std::cbrt(12.0 * std::pow(sigma_m * c.rate_hz / (kKnownShare * c.intruder_mps), 2.0));
  return (std::max(kSamples, samples) + kLost) / c.rate_hz;
}

double needed_warning_s(const RblConditions& c) {
  const double faster_m = 0.5 * c.speed_mps * c.speed_mps / c.acceleration_mps2;  // distance to reach its speed
  const double aside_s = kept_m(c) < faster_m
                             ? std::sqrt(2.0 * kept_m(c) / c.acceleration_mps2)
                             : c.speed_mps / c.acceleration_mps2 + (kept_m(c) - faster_m) / c.speed_mps;
  return known_after_s(c) + c.latency_s + c.reaction_s + aside_s;
}

double predicted_distance_m(const RblConditions& c) {
  if (c.intruder_mps <= 0.0) return among_themselves_m(c);
  if (!c.all_around) return 0.0;
  return std::min(among_themselves_m(c), aside_m(c));
}

RblObstacle obstacle_of(const RblConditions& c) {
  if (predicted_distance_m(c) > kTouching_m) return RblObstacle::kNone;
  if (c.intruder_mps > 0.0 && !c.all_around) return RblObstacle::kUnseen;
  if (c.intruder_mps > 0.0 && aside_m(c) <= kTouching_m) return RblObstacle::kLate;
  return RblObstacle::kNoise;
}

}  // namespace swiftlet::tools
