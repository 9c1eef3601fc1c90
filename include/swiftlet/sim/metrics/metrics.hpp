// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {

/// Table types of all registered metrics.
std::vector<TableType> series_types();

/// All metrics of one run.
class Metrics {
 public:
  /// @param perception  indexed by VehicleId; empty: no vehicle detects or tracks
  Metrics(const MetricsConfig& config, std::vector<std::string> vehicle_names, std::vector<Perception> perception = {});

  /// Call after every tick. `clearances` is indexed by VehicleId.
  void update(const TickView& tick, std::span<const Clearance> clearances);

  /// The tables of all metrics, with the rows of the last update.
  const std::vector<const Series*>& series() const { return series_; }

  MetricTable report() const;
  std::vector<MetricRow> rows() const { return report().rows(); }
  /// Outcome of the run, the worst of its vehicles: "crashed", "failed", "timeout" (a mission was still running),
  /// "done".
  std::string outcome() const;

 private:
  std::vector<std::unique_ptr<Metric>> metrics_;
  std::vector<const Series*> series_;
  TimeNs t_last_ = 0;
  std::vector<char> flying_;  // indexed by VehicleId
};

/// Names of all metrics; empty when a row of the registry does not list its metrics.
std::optional<std::vector<std::string>> metric_names();
/// Content of docs/metrics.md: definitions of the results of a run.
std::string metrics_reference();

}  // namespace swiftlet::sim
