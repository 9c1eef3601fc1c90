// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "swiftlet/core/counter.hpp"
#include "swiftlet/sim/metrics/metric_table.hpp"
#include "swiftlet/sim/radio/radio_statistics.hpp"

namespace swiftlet::sim {

/// What a run came to: the content of summary.json.
struct RunSummary {
  std::string scenario;
  std::uint64_t seed = 0;
  std::string outcome;
  std::uint64_t state_hash = 0;
  int threads = 1;
  double simulated_s = 0.0;
  double setup_wall_s = 0.0;  ///< world, trace structure, vehicles
  double wall_s = 0.0;        ///< the flight with its recording
  std::vector<std::pair<std::string, double>> stage_wall_s;
  MetricTable metrics;
  RadioStatistics radio;
  std::vector<RadioTopicStatistics> radio_topics;
  std::vector<Counter> counters;  ///< what did not fit; settings by their path in the scenario

  double real_time_factor() const { return wall_s > 0.0 ? simulated_s / wall_s : 0.0; }
};

/// summary.json: everything above with version and revision, keys in a fixed order.
std::string to_json(const RunSummary& summary);

/// A line for each counter above zero; those of several vehicles in one.
std::string to_text(const std::vector<Counter>& counters);

/// A screenful for people.
std::string to_text(const RunSummary& summary);

}  // namespace swiftlet::sim
