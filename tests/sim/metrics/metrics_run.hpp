// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "swiftlet/sim/metrics/metrics.hpp"

namespace swiftlet::sim {

inline constexpr TimeNs kTick = 10'000'000;

/// Feeds metrics with ticks whose states and actions are set by a test.
struct MetricsRun {
  explicit MetricsRun(int num_vehicles, MetricsConfig config = {}, std::vector<Perception> perception = {})
      : states(num_vehicles),
        actions(num_vehicles),
        clearances(num_vehicles),
        observations(num_vehicles),
        scans(num_vehicles),
        metrics(config, names(num_vehicles), perception) {
    for (Clearance& clearance : clearances) {
      clearance.surface_m = 5.0;
      clearance.vehicle_m = std::numeric_limits<double>::infinity();
    }
  }
  static std::vector<std::string> names(int n) {
    std::vector<std::string> names;
    for (int i = 0; i < n; ++i) names.push_back("uav" + std::to_string(i + 1));
    return names;
  }

  double next_s() const { return to_seconds(now + kTick); }
  void tick() {
    now += kTick;
    pointers.clear();
    for (const Action& action : actions) pointers.push_back(&action);
    for (VehicleState& state : states) state.t = now;
    TickView view;
    view.t = now;
    view.states = states;
    view.observations = observations;
    view.actions = pointers;
    view.scans = scans;
    view.events = events;
    view.agents = agents;
    metrics.update(view, clearances);
    events.clear();
  }
  double value(const std::string& name, const std::string& vehicle = "uav1") const {
    const MetricTable table = metrics.report();
    const MetricRow* row = table.find(name, vehicle);
    if (row == nullptr) throw std::out_of_range(name);
    return row->value;
  }
  std::string text(const std::string& name, const std::string& vehicle = "uav1") const {
    const MetricTable table = metrics.report();
    const MetricRow* row = table.find(name, vehicle);
    if (row == nullptr) throw std::out_of_range(name);
    return row->text;
  }

  TimeNs now = 0;
  std::vector<VehicleState> states;
  std::vector<Action> actions;
  std::vector<Clearance> clearances;
  std::vector<Observation> observations;
  std::vector<std::vector<std::shared_ptr<const LabeledScan>>> scans;
  std::vector<Event> events;
  std::vector<std::unique_ptr<Agent>> agents;  // none, unless a test sets them
  std::vector<const Action*> pointers;
  Metrics metrics;
};

}  // namespace swiftlet::sim
