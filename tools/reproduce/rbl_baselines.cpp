// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <vector>

#include "core/agent/stack.hpp"
#include "core/guidance/flocking.hpp"
#include "core/guidance/rbl.hpp"
#include "core/guidance/registry.hpp"
#include "crossing.hpp"
#include "experiments.hpp"

namespace swiftlet::tools {

// The same crossings with PACNav, with the vision-based model and with RBL: neighbours are perfect for all three.
void rbl_baselines(Experiment& experiment) {
  const int seeds = experiment.repetitions(20, 1);
  CsvTable csv({"case", "vehicles", "success", "length_m", "time_s", "slowest_s", "min_separation_m"});
  for (const int n : {5, 10}) {
    for (const std::string guidance : {"rbl", "pacnav", "mezey"}) {
      std::vector<sim::Scenario> scenarios;
      for (int seed = 1; seed <= seeds; ++seed) {
        sim::Scenario pattern = scenario_with("reproduce/rbl_crossing.yaml", static_cast<std::uint64_t>(seed),
                                              {{"vehicles[0].sensors[0].ideal", "true"}});
        Module& module = pattern.vehicles.front().agent.as<StackConfig>().guidance;
        if (guidance != "rbl") module = Module(guidance_module_types(), guidance);
        scenarios.push_back(make_crossing(pattern, {false, n, 10.0}, 5.0));
      }
      const CrossingTable table = summarize(fly_crossings(experiment, scenarios), n);
      csv.row(guidance, {static_cast<double>(n), table.success, table.length_m.mean, table.time_s.mean,
                         table.slowest_s.mean, table.min_separation_m});
      const std::string what = fmt::format("{} circle N={}: ", guidance, n);
      experiment.row({what + "success [-]", "-", fmt::format("{:.2f}", table.success), Verdict::kNotComparable,
                      fmt::format("least separation {:.2f} m", table.min_separation_m), table.success});
      experiment.row({what + "t [s]", "-", fmt::format("{:.2f}", table.time_s.mean), Verdict::kNotComparable,
                      "of the flights that succeeded", table.time_s.mean});
    }
  }
  experiment.write("baselines.csv", csv);
}

}  // namespace swiftlet::tools
