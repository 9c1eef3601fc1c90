// SPDX-License-Identifier: BSD-3-Clause
#include "scenario_options.hpp"

#include <fmt/format.h>

#include "plugin_options.hpp"
#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::tools {

void ScenarioOptions::add_to(Subcommand& command) {
  command.option("scenario", file, "Scenario file, or the name of one of Swiftlet's",
                 {.value_name = "SCENARIO.yaml", .required = true});
  command.option("--seed", seed, "Random seed (default: the scenario's)", {.value_name = "N"});
  command.option("--duration", duration_s, "Length of the run (default: the scenario's)",
                 {.value_name = "SECONDS", .min = 0.0, .max = 1e7});
  command.option("--set", set, "Override any key: --set vehicles[0].start.yaw_deg=90 (may be repeated)",
                 {.value_name = "KEY=VALUE", .repeated = true});
  add_allow_plugins(command, allow_plugins);
}

ConfigChanges parse_assignments(const std::vector<std::string>& set) {
  ConfigChanges overrides;
  for (const std::string& assignment : set) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw sim::InputError(
          fmt::format("--set {}: expected KEY=VALUE, such as vehicles[0].start.yaw_deg=90", assignment));
    }
    overrides.emplace_back(assignment.substr(0, equals), assignment.substr(equals + 1));
  }
  return overrides;
}

sim::Scenario ScenarioOptions::load() const {
  if (allow_plugins) tools::allow_plugins();
  ConfigChanges overrides = parse_assignments(set);
  if (seed) overrides.emplace_back("seed", std::to_string(*seed));
  if (duration_s) overrides.emplace_back("duration_s", fmt::format("{}", *duration_s));
  return sim::load_scenario(file, overrides);
}

}  // namespace swiftlet::tools
