// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "plugin_options.hpp"
#include "progress.hpp"
#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/stage_tables/detectors.hpp"
#include "swiftlet/core/stage_tables/estimators.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"
#include "swiftlet/core/stage_tables/mappers.hpp"
#include "swiftlet/core/stage_tables/relative_localizers.hpp"
#include "swiftlet/core/stage_tables/trackers.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/metrics/metric.hpp"
#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/scenario/assets.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"
#include "swiftlet/sim/sensors/lidar_pattern.hpp"

namespace swiftlet::tools {
namespace {

/// One section of the list. `doc` names the key of the scenario whose values it lists, or its use.
struct Kind {
  const char* name;
  const char* doc;
  void (*print)();
};

void print_line(std::string_view name, std::string_view doc) { fmt::print("  {:<24} {}\n", name, doc); }

void print_types(std::span<const ModuleType> types) {
  for (const ModuleType& type : types) print_line(type.name, type.doc);
}

void print_metrics() {
  for (const sim::MetricType& type : sim::metric_registry()) {
    for (const sim::MetricDefinition& metric : type.definitions) print_line(metric.name, metric.definition);
  }
}

void print_outcomes() {
  for (const sim::OutcomeDefinition& outcome : sim::outcome_definitions()) print_line(outcome.name, outcome.definition);
}

/// Prints each overlay with the stages that draw it.
void print_overlays() {
  std::vector<std::pair<std::string, std::string>> overlays = {
      {"reference", "the stack agent"}, {"tracks", "any tracker"}, {"tracks.covariance", "any tracker"}};
  const auto add = [&](const char* stage, const auto& registry) {
    for (const auto& row : registry.rows()) {
      std::istringstream names(row.overlays != nullptr ? row.overlays : "");
      for (std::string name; names >> name;) {
        const auto known =
            std::find_if(overlays.begin(), overlays.end(), [&](const auto& line) { return line.first == name; });
        if (known == overlays.end())
          overlays.emplace_back(name, fmt::format("{} {}", stage, row.module.name));
        else
          known->second += fmt::format(", {}", row.module.name);
      }
    }
  };
  add("localization", estimator_registry());
  add("detector", detector_registry());
  add("relative_localization", relative_localizer_registry());
  add("mapping", mapper_registry());
  add("guidance", guidance_registry());
  for (const auto& [name, stages] : overlays) print_line(name, "drawn by " + stages);
}

void print_assets(const char* folder) {
  for (const sim::Asset& asset : sim::list_assets(folder)) print_line(asset.name, asset.doc);
}

constexpr Kind kKinds[] = {
    {"scenarios", "scenarios that come with Swiftlet", [] { print_assets("scenarios"); }},
    {"batches", "batch files that come with Swiftlet: swiftlet batch batch/NAME",
     [] { print_assets("scenarios/batch"); }},
    {"datasets", "dataset files that come with Swiftlet: swiftlet dataset dataset/NAME",
     [] { print_assets("scenarios/dataset"); }},
    {"worlds", "world.type", [] { print_types(sim::world_module_types()); }},
    {"vehicles", "vehicles[].model", [] { print_assets("vehicles"); }},
    {"sensors", "vehicles[].sensors[].type", [] { print_types(sim::sensor_module_types()); }},
    {"sensor_models", "vehicles[].sensors[].model", [] { print_assets("sensors"); }},
    {"patterns", "vehicles[].sensors[].pattern.type of a LiDAR", [] { print_types(sim::lidar_pattern_types()); }},
    {"agents", "vehicles[].agent.type", [] { print_types(agent_module_types()); }},
    {"localization", "vehicles[].agent.localization.type", [] { print_types(estimator_module_types()); }},
    {"detectors", "vehicles[].agent.detector.type", [] { print_types(detector_module_types()); }},
    {"trackers", "vehicles[].agent.tracker.type", [] { print_types(tracker_module_types()); }},
    {"relative_localization", "vehicles[].agent.relative_localization.type",
     [] { print_types(relative_localizer_module_types()); }},
    {"mapping", "vehicles[].agent.mapping.type", [] { print_types(mapper_module_types()); }},
    {"guidance", "vehicles[].agent.guidance.type", [] { print_types(guidance_module_types()); }},
    {"recorders", "recorders[].type", [] { print_types(sim::recorder_module_types()); }},
    {"overlays", "snapshots[].overlays; for one vehicle: uav1/NAME", print_overlays},
    {"metrics", "in summary.json, and for report.metrics of a batch (docs/metrics.md)", print_metrics},
    {"outcomes", "in summary.json: how the run and the flight of each vehicle ended", print_outcomes},
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
  Subcommand command(app, "list",
                     "List the types, models, files, overlays and metrics that a scenario or batch can name");
  command.option("kind", *wanted, "List only this kind: sensors, vehicles, worlds, agents, recorders ...");
  auto plugins = std::make_shared<PluginOptions>();
  plugins->add_to(command);
  command.action([wanted, plugins] {
    plugins->load();
    list(*wanted);
  });
}

}  // namespace swiftlet::tools
