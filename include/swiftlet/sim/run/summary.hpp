// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/sim/metrics/metric_table.hpp"
#include "swiftlet/sim/radio/radio_statistics.hpp"

namespace swiftlet::sim {

/// Result of a run: the content of summary.json.
struct RunSummary {
  std::string scenario;
  std::uint64_t seed = 0;
  std::string outcome;
  std::uint64_t state_hash = 0;
  int threads = 1;
  double simulated_s = 0.0;
  double setup_wall_s = 0.0;  ///< creation of world, ray-tracing structure, vehicles
  double wall_s = 0.0;        ///< flight including recording
  std::vector<std::pair<std::string, double>> stage_wall_s;
  MetricTable metrics;
  RadioStatistics radio;
  std::vector<RadioTopicStatistics> radio_topics;
  std::vector<Counter> counters;  ///< data beyond limits or formats; settings by their path in the scenario

  double real_time_factor() const { return wall_s > 0.0 ? simulated_s / wall_s : 0.0; }
};

/// summary.json: all fields above with version and revision, keys in a fixed order.
std::string to_json(const RunSummary& summary);

/// One line per nonzero counter, summed over vehicles.
std::string to_text(const std::vector<Counter>& counters);

/// Readable summary for a terminal.
std::string to_text(const RunSummary& summary);

}  // namespace swiftlet::sim
