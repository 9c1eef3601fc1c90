// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "experiments.hpp"
#include "parallel.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/mapping/sparse_mapper.hpp"

namespace swiftlet::tools {

// UAVs that pass leave occupied cells, which lock the vehicle in unless the map clears them.
void rbl_ghosts(Experiment& experiment) {
  const int seeds = experiment.repetitions(10, 1);
  CsvTable csv({"map", "seed", "arrived", "time_s"});
  const auto arrived = [&](const std::string& name, bool conservative) {
    std::vector<sim::Scenario> scenarios;
    for (int seed = 1; seed <= seeds; ++seed) {
      sim::Scenario scenario = scenario_with("reproduce/rbl_ghosts.yaml", static_cast<std::uint64_t>(seed));
      scenario.recorders.clear();
      scenario.snapshots.clear();
      auto& mapping = scenario.vehicles.front().agent.as<StackConfig>().mapping.as<SparseMapperConfig>();
      if (conservative) mapping.map.miss_log_odds = 0.0;
      scenarios.push_back(std::move(scenario));
    }
    const std::vector<double> time_s =
        metric_of(fly(experiment, scenarios), "time_to_done_s", scenarios.front().vehicles.front().name);
    for (std::size_t i = 0; i < time_s.size(); ++i) {
      csv.row(name, {static_cast<double>(i + 1), std::isnan(time_s[i]) ? 0.0 : 1.0, time_s[i]});
    }
    return static_cast<double>(mean_and_deviation(time_s).count) / seeds;
  };
  const double locked = arrived("conservative", true), free = arrived("forgets", false);
  experiment.claim("a map that never clears locks the vehicle in", fmt::format("{:.0f} % arrive", 100.0 * locked),
                   locked == 0.0, "sec. 3.4, leaves mapped as obstacles");
  experiment.claim("a map that forgets does not", fmt::format("{:.0f} % arrive", 100.0 * free), free == 1.0);
  experiment.write("ghosts.csv", csv);
}

}  // namespace swiftlet::tools
