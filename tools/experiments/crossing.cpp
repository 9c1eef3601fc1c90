// SPDX-License-Identifier: BSD-3-Clause
#include "crossing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/flocking.hpp"
#include "swiftlet/core/guidance/orca.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/guidance/share_paths.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kStartSpread_m = 0.1;
constexpr double kForgotten_s = 3.0;  // plus two sensor periods: a longer gap restarts the warning time

/// Evenly spaced on the circle, or along a golden-angle spiral on the sphere.
Vector3 direction(const Formation& formation, int i) {
  const int n = formation.num_vehicles;
  if (!formation.sphere) {
    const double angle = 2.0 * kPi * i / n;
    return {std::cos(angle), std::sin(angle), 0.0};
  }
  const double z = formation.poles ? 1.0 - 2.0 * i / std::max(1, n - 1) : 1.0 - (2.0 * i + 1.0) / n;
  const double rho = std::sqrt(std::max(0.0, 1.0 - z * z));
  const double angle = kPi * (3.0 - std::sqrt(5.0)) * i;
  return {rho * std::cos(angle), rho * std::sin(angle), z};
}

}  // namespace

void set_goal(sim::VehicleConfig& vehicle, const Eigen::Vector3d& goal_m) {
  Module& guidance = vehicle.agent.as<StackConfig>().guidance;
  if (guidance.type == "rbl") {
    guidance.as<RblConfig>().goal_m = goal_m;
  } else if (guidance.type == "pacnav") {
    guidance.as<PacnavConfig>().goal_m = goal_m;
  } else if (guidance.type == "mezey") {
    guidance.as<MezeyConfig>().goal_m = goal_m;
  } else if (guidance.type == "orca") {
    guidance.as<OrcaConfig>().goal_m = goal_m;
  } else if (guidance.type == "share_paths") {
    guidance.as<SharePathsConfig>().goal_m = goal_m;
  } else {
    throw std::invalid_argument("crossing: guidance '" + guidance.type + "' has no goal");
  }
}

sim::Scenario make_crossing(const sim::Scenario& pattern, const Formation& formation, double height_m) {
  sim::Scenario scenario = pattern;
  scenario.vehicles.clear();
  scenario.recorders.clear();
  scenario.snapshots.clear();
  const Random random(scenario.seed, "crossing.start");
  const Vector3 center(0.0, 0.0, height_m);
  for (int i = 0; i < formation.num_vehicles; ++i) {
    sim::VehicleConfig vehicle = pattern.vehicles.front();
    vehicle.name = "uav" + std::to_string(i + 1);
    const Vector3 from = formation.radius_m * direction(formation, i);
    vehicle.start.position_m = center + from;
    for (int axis = 0; axis < (formation.sphere ? 3 : 2); ++axis) {
      vehicle.start.position_m[axis] += random.uniform(-kStartSpread_m, kStartSpread_m, static_cast<std::uint32_t>(i),
                                                       static_cast<std::uint32_t>(axis));
    }
    vehicle.start.yaw_deg = std::atan2(-from.y(), -from.x()) * 180.0 / kPi;
    set_goal(vehicle, center - from);
    scenario.vehicles.push_back(std::move(vehicle));
  }
  return scenario;
}

std::vector<CrossingResult> fly_crossings(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios) {
  struct Way {
    Vector3 last_m = Vector3::Zero();
    double length_m = 0.0, time_s = 0.0;
    bool known = false, arrived = false;
  };
  // The intruder flies straight through by waypoints: when each vehicle first and last measured it, and its least
  // distance to an rbl vehicle.
  struct Stranger {
    int index = -1;                 // -1: none
    std::vector<bool> avoids;       // flies by rbl
    std::vector<TimeNs> forgotten;  // longest gap between samples before warning restarts
    std::vector<TimeNs> first, last;
    double least_m = std::numeric_limits<double>::infinity(), warned_s = 0.0;
  };
  std::vector<Stranger> strangers(scenarios.size());
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    const auto& vehicles = scenarios[i].vehicles;
    for (std::size_t v = 0; v < vehicles.size(); ++v) {
      const std::string& type = vehicles[v].agent.as<StackConfig>().guidance.type;
      if (type == "waypoints") strangers[i].index = static_cast<int>(v);
      strangers[i].avoids.push_back(type == "rbl");
      double period_s = 0.0;
      for (const Module& sensor : vehicles[v].sensors) {
        if (sensor.type == "neighbors") period_s = 1.0 / sensor.as<sim::NeighborsConfig>().rate_hz;
      }
      strangers[i].forgotten.push_back(from_seconds(kForgotten_s + 2.0 * period_s));
    }
    strangers[i].first.assign(vehicles.size(), -1);
    strangers[i].last.assign(vehicles.size(), -1);
  }
  const auto warn = [&](Stranger& stranger, const sim::TickView& view) {
    if (stranger.index < 0) return;
    for (std::size_t v = 0; v < view.states.size(); ++v) {
      if (!stranger.avoids[v]) continue;
      for (const NeighborSample& sample : view.observations[v].neighbors) {
        if (sample.id != static_cast<VehicleId>(stranger.index)) continue;
        if (stranger.first[v] < 0 || view.t - stranger.last[v] > stranger.forgotten[v]) stranger.first[v] = view.t;
        stranger.last[v] = view.t;
      }
      const double d = (view.states[v].p_world_m - view.states[stranger.index].p_world_m).norm();
      if (d >= stranger.least_m) continue;
      stranger.least_m = d;
      stranger.warned_s = stranger.first[v] < 0 ? 0.0 : to_seconds(view.t - stranger.first[v]);
    }
  };
  std::vector<std::vector<Way>> ways(scenarios.size());
  for (std::size_t i = 0; i < scenarios.size(); ++i) ways[i].resize(scenarios[i].vehicles.size());
  const auto follow = [&](std::size_t index, const sim::Simulation& simulation) {
    const sim::TickView& view = simulation.view();
    warn(strangers[index], view);
    for (std::size_t v = 0; v < ways[index].size(); ++v) {
      Way& way = ways[index][v];
      if (way.arrived) continue;
      const Vector3& p_m = view.states[v].p_world_m;
      if (way.known) way.length_m += (p_m - way.last_m).norm();
      way.last_m = p_m;
      way.known = true;
      if (view.actions[v]->mission != MissionStatus::kDone) continue;
      way.arrived = true;
      way.time_s = to_seconds(view.t);
    }
  };
  // Length and time of each vehicle (time NaN: not arrived), then the intruder's two numbers.
  const auto write = [&](std::size_t index) {
    std::vector<double> numbers;
    for (const Way& way : ways[index]) {
      numbers.push_back(way.length_m);
      numbers.push_back(way.arrived ? way.time_s : std::numeric_limits<double>::quiet_NaN());
    }
    numbers.push_back(strangers[index].least_m);
    numbers.push_back(strangers[index].warned_s);
    return numbers;
  };
  const auto read = [&](std::size_t index, std::span<const double> numbers) {
    strangers[index].least_m = numbers[numbers.size() - 2];
    strangers[index].warned_s = numbers[numbers.size() - 1];
    for (std::size_t v = 0; v < ways[index].size(); ++v) {
      ways[index][v].length_m = numbers[2 * v];
      ways[index][v].time_s = numbers[2 * v + 1];
      ways[index][v].arrived = !std::isnan(numbers[2 * v + 1]);
    }
  };
  const auto runs = fly(experiment, scenarios, {.after_tick = follow, .write = write, .read = read});
  std::vector<CrossingResult> results(scenarios.size());
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    CrossingResult& result = results[i];
    for (const Way& way : ways[i]) {
      if (!way.arrived) continue;
      result.length_m.push_back(way.length_m);
      result.time_s.push_back(way.time_s);
      ++result.num_arrived;
    }
    result.crashed = runs[i].outcome == "crashed";
    if (strangers[i].index >= 0) {
      result.stranger_m = strangers[i].least_m;
      result.warned_s = strangers[i].warned_s;
    }
    const sim::MetricRow* separation = runs[i].metrics.find("min_separation_m");
    result.min_separation_m = separation != nullptr ? separation->value : std::numeric_limits<double>::quiet_NaN();
  }
  return results;
}

CrossingTable summarize(const std::vector<CrossingResult>& flights, int num_vehicles) {
  CrossingTable table;
  table.min_separation_m = std::numeric_limits<double>::infinity();
  std::vector<double> length_m, time_s, slowest_s, speed_mps;
  int num_succeeded = 0, num_arrived = 0, num_crashed = 0;
  for (const CrossingResult& flight : flights) {
    table.min_separation_m = std::min(table.min_separation_m, flight.min_separation_m);
    num_arrived += flight.num_arrived;
    num_crashed += flight.crashed;
    if (flight.crashed || flight.num_arrived < num_vehicles) continue;
    ++num_succeeded;
    length_m.insert(length_m.end(), flight.length_m.begin(), flight.length_m.end());
    time_s.insert(time_s.end(), flight.time_s.begin(), flight.time_s.end());
    slowest_s.push_back(*std::max_element(flight.time_s.begin(), flight.time_s.end()));
    for (std::size_t i = 0; i < flight.length_m.size(); ++i) speed_mps.push_back(flight.length_m[i] / flight.time_s[i]);
  }
  const auto num_flights = static_cast<double>(flights.size());
  table.success = num_succeeded / num_flights;
  table.arrived = num_arrived / (num_flights * num_vehicles);
  table.crashed = num_crashed / num_flights;
  table.length_m = mean_and_deviation(length_m);
  table.time_s = mean_and_deviation(time_s);
  table.slowest_s = mean_and_deviation(slowest_s);
  table.speed_mps = mean_and_deviation(speed_mps);
  return table;
}

}  // namespace swiftlet::tools
