// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <string>

#include "commands.hpp"
#include "scenario_options.hpp"
#include "sim/batch/batch_plan.hpp"
#include "sim/dataset/flight.hpp"
#include "sim/scenario/loader.hpp"
#include "swiftlet/sim/simulation.hpp"

namespace swiftlet::tools {
namespace {

// A batch file is known by a key that no scenario has. It is checked with every scenario that it names.
bool is_batch_file(const sim::Node& document) {
  for (const char* key : {"scenario", "variants", "sweep", "seeds"}) {
    if (document.find(key) != nullptr) return true;
  }
  return false;
}

// So is a dataset file.
bool is_dataset_file(const sim::Node& document) {
  return document.find("splits") != nullptr || document.find("families") != nullptr;
}

}  // namespace

void add_check(CLI::App& app) {
  auto options = std::make_shared<ScenarioOptions>();
  Subcommand command(app, "check", "Validate a scenario, a batch or a dataset file; prints nothing when all is well");
  options->add_to(command);
  command.action([options] {
    const sim::Node document = sim::Loader(sim::system_files()).load(options->file);
    if (is_batch_file(document)) {
      (void)sim::BatchPlan(options->file, parse_assignments(options->set));
    } else if (is_dataset_file(document)) {
      (void)sim::plan_dataset(sim::load_dataset(options->file, parse_assignments(options->set)));
    } else {
      (void)options->load();
    }
  });
}

}  // namespace swiftlet::tools
