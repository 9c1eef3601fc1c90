// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <memory>
#include <set>
#include <string>
#include <utility>

#include "commands.hpp"
#include "plugin_options.hpp"
#include "scenario_options.hpp"
#include "scratch_folder.hpp"
#include "swiftlet/sim/batch/batch_plan.hpp"
#include "swiftlet/sim/dataset/flight.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/scenario/loader.hpp"

namespace swiftlet::tools {
namespace {

// A batch file is recognized by a key that no scenario has. It is checked with every scenario that it names.
bool is_batch_file(const sim::Node& document) {
  for (const char* key : {"scenario", "variants", "sweep", "seeds"}) {
    if (document.find(key) != nullptr) return true;
  }
  return false;
}

// A dataset file is recognized in the same manner.
bool is_dataset_file(const sim::Node& document) {
  return document.find("splits") != nullptr || document.find("families") != nullptr;
}

/// Does all that a run does before its first tick, so that a scenario that passes can be flown.
void require_flyable(sim::Scenario scenario) {
  sim::Simulation simulation(std::move(scenario));
  const ScratchFolder folder;  // created after the long part, since an interrupt ends the program at once
  simulation.attach_recorders(folder.path());
  fmt::print(stderr, "{}", sim::to_text(simulation.summary().counters));  // parts of its files that were omitted
}

/// One episode of each variant.
void require_flyable(const sim::BatchPlan& plan) {
  std::set<std::uint64_t> seen;
  for (std::uint64_t id = 0; id < plan.num_episodes() && seen.size() < plan.config().variants.size() + 1; ++id) {
    const auto episode = plan.episode(id);
    if (seen.insert(episode.variant).second) {
      sim::Scenario scenario = plan.scenario_of(episode);
      scenario.snapshots.clear();  // episodes of a batch take no pictures
      require_flyable(std::move(scenario));
    }
    if (plan.config().variants.empty()) break;
  }
}

}  // namespace

void add_check(CLI::App& app) {
  auto options = std::make_shared<ScenarioOptions>();
  Subcommand command(app, "check", "Validate a scenario, a batch or a dataset file; prints nothing if it is valid");
  options->add_to(command);
  command.action([options] {
    if (options->allow_plugins) allow_plugins();  // also for batches and datasets
    const sim::Node document = sim::Loader(sim::system_files()).load(options->file);
    if (is_batch_file(document)) {
      require_flyable(sim::BatchPlan(options->file, parse_assignments(options->set)));
    } else if (is_dataset_file(document)) {
      (void)sim::plan_dataset(sim::load_dataset(options->file, parse_assignments(options->set)));
    } else {
      require_flyable(options->load());
    }
  });
}

}  // namespace swiftlet::tools
