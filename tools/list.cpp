// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "progress.hpp"
#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/stages/detectors.hpp"
#include "swiftlet/core/stages/estimators.hpp"
#include "swiftlet/core/stages/guidances.hpp"
#include "swiftlet/core/stages/mappers.hpp"
#include "swiftlet/core/stages/trackers.hpp"
#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/scenario/assets.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"
#include "swiftlet/sim/view/recorder.hpp"

namespace swiftlet::tools {
namespace {

struct Kind {
  const char* name;
  const char* doc;
  void (*print)();
};

void print_types(std::span<const ModuleType> types) {
  for (const ModuleType& type : types) fmt::print("  {:<18} {}\n", type.name, type.doc);
}

void print_assets(const char* folder) {
  for (const sim::Asset& asset : sim::list_assets(folder)) fmt::print("  {:<18} {}\n", asset.name, asset.doc);
}

constexpr Kind kKinds[] = {
    {"scenarios", "scenarios that come with Swiftlet", [] { print_assets("scenarios"); }},
    {"worlds", "world.type", [] { print_types(sim::world_module_types()); }},
    {"vehicles", "vehicles[].model", [] { print_assets("vehicles"); }},
    {"sensors", "vehicles[].sensors[].type", [] { print_types(sim::sensor_module_types()); }},
    {"sensor_models", "vehicles[].sensors[].model", [] { print_assets("sensors"); }},
    {"agents", "vehicles[].agent.type", [] { print_types(agent_module_types()); }},
    {"localization", "vehicles[].agent.localization.type", [] { print_types(estimator_module_types()); }},
    {"detectors", "vehicles[].agent.detector.type", [] { print_types(detector_module_types()); }},
    {"trackers", "vehicles[].agent.tracker.type", [] { print_types(tracker_module_types()); }},
    {"mapping", "vehicles[].agent.mapping.type", [] { print_types(mapper_module_types()); }},
    {"guidance", "vehicles[].agent.guidance.type", [] { print_types(guidance_module_types()); }},
    {"recorders", "recorders[].type", [] { print_types(sim::recorder_module_types()); }},
};

void list(const std::string& wanted) {
  bool found = false;
  for (const Kind& kind : kKinds) {
    if (!wanted.empty() && wanted != kind.name) continue;
    found = true;
    fmt::print("{} ({})\n", bold(kind.name), kind.doc);
    kind.print();
  }
  if (found) return;
  std::vector<std::string> known;
  for (const Kind& kind : kKinds) known.emplace_back(kind.name);
  throw sim::InputError(
      fmt::format("list {}: expected one of {}{}", wanted, fmt::join(known, ", "), sim::did_you_mean(wanted, known)));
}

}  // namespace

void add_list(CLI::App& app) {
  auto wanted = std::make_shared<std::string>();
  Subcommand command(app, "list", "What can be named in a scenario");
  command.option("kind", *wanted, "Only this kind: sensors, vehicles, worlds, agents, recorders ...");
  command.action([wanted] { list(*wanted); });
}

}  // namespace swiftlet::tools
