// SPDX-License-Identifier: BSD-3-Clause
#include "scenario_options.hpp"

#include <fmt/format.h>

#include "swiftlet/sim/errors.hpp"

namespace swiftlet::tools {

void ScenarioOptions::add_to(CLI::App& command) {
  command.add_option("scenario", file, "Scenario file, or the name of one that comes with Swiftlet")->required()->type_name("SCENARIO.yaml");
  command.add_option("--seed", seed, "Seed of every random number (default: the scenario's)")->type_name("N");
  command.add_option("--duration", duration_s, "Length of the run (default: the scenario's)")->type_name("SECONDS");
  command.add_option("--set", set, "Override any key: --set vehicles[0].start.yaw_deg=90 (may be repeated)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

sim::Scenario ScenarioOptions::load() const {
  std::vector<std::pair<std::string, std::string>> overrides;
  for (const std::string& assignment : set) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw sim::InputError(fmt::format("--set {}: expected KEY=VALUE, such as vehicles[0].start.yaw_deg=90", assignment));
    }
    overrides.emplace_back(assignment.substr(0, equals), assignment.substr(equals + 1));
  }
  if (seed) overrides.emplace_back("seed", std::to_string(*seed));
  if (duration_s) overrides.emplace_back("duration_s", fmt::format("{}", *duration_s));
  return sim::load_scenario(file, overrides);
}

}  // namespace swiftlet::tools
