// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <string>

#include "commands.hpp"
#include "scenario_options.hpp"
#include "sim/batch/batch_plan.hpp"
#include "sim/scenario/loader.hpp"
#include "swiftlet/sim/simulation.hpp"

namespace swiftlet::tools {
namespace {

// A batch file is known by a key that no scenario has. It is checked with every scenario that it names.
bool is_batch_file(const std::string& file) {
  const sim::Node document = sim::Loader(sim::system_files()).load(file);
  for (const char* key : {"scenario", "variants", "sweep", "seeds"}) {
    if (document.find(key) != nullptr) return true;
  }
  return false;
}

}  // namespace

void add_check(CLI::App& app) {
  auto options = std::make_shared<ScenarioOptions>();
  Subcommand command(app, "check", "Validate a scenario or a batch file; prints nothing when all is well");
  options->add_to(command);
  command.action([options] {
    if (is_batch_file(options->file)) {
      (void)sim::BatchPlan(options->file, parse_assignments(options->set));
    } else {
      (void)options->load();
    }
  });
}

}  // namespace swiftlet::tools
