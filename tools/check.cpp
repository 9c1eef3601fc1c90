// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include "commands.hpp"
#include "scenario_options.hpp"
#include "swiftlet/sim/simulation.hpp"

namespace swiftlet::tools {

void add_check(CLI::App& app) {
  auto options = std::make_shared<ScenarioOptions>();
  Subcommand command(app, "check", "Validate a configuration; prints nothing when all is well");
  options->add_to(command);
  command.action([options] { (void)options->load(); });
}

}  // namespace swiftlet::tools
