// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include "commands.hpp"
#include "scenario_options.hpp"
#include "swiftlet/sim/simulation.hpp"

namespace swiftlet::tools {

void add_check(CLI::App& app) {
  auto options = std::make_shared<ScenarioOptions>();
  CLI::App* command = app.add_subcommand("check", "Validate a configuration; prints nothing when all is well");
  options->add_to(*command);
  command->callback([options] { (void)options->load(); });
}

}  // namespace swiftlet::tools
