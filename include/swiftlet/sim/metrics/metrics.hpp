// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {

/// The tables of all metrics that a run has.
std::vector<TableType> series_types();

/// All metrics of one run.
class Metrics {
 public:
  /// @param perception  by VehicleId; empty: nobody detects or tracks
  Metrics(const MetricsConfig& config, std::vector<std::string> vehicle_names, std::vector<Perception> perception = {});

  /// After every tick. `clearances` by VehicleId.
  void update(const TickView& tick, std::span<const Clearance> clearances);

  /// The tables of all metrics; rows are those of the last update.
  const std::vector<const Series*>& series() const { return series_; }

  MetricTable report() const;
  std::vector<MetricRow> rows() const { return report().rows(); }
  /// Of the run, the worst of its vehicles': "crashed", "failed", "timeout" (a mission that was still running), "done".
  std::string outcome() const;

 private:
  std::vector<std::unique_ptr<Metric>> metrics_;
  std::vector<const Series*> series_;
  TimeNs t_last_ = 0;
  std::vector<char> flying_;  // by VehicleId
};

/// Names of all that may be measured; nothing when a row of the registry does not tell its own.
std::optional<std::vector<std::string>> metric_names();
/// docs/metrics.md: what the results of a run mean.
std::string metrics_reference();

}  // namespace swiftlet::sim
