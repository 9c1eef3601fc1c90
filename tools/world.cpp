// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "scenario_options.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/world/export.hpp"

namespace swiftlet::tools {
namespace {

struct WorldOptions {
  ScenarioOptions scenario;
  std::string out;
  bool quiet = false;
};

void export_scenario_world(const WorldOptions& options) {
  const sim::Scenario scenario = options.scenario.load();
  const std::filesystem::path out(options.out);
  if (out.has_parent_path()) sim::make_directory(out.parent_path());
  const sim::Scene scene = sim::make_world(scenario.world, scenario.seed_of_world());
  const auto written = sim::export_world(scene, out);
  if (options.quiet) return;
  fmt::print("{} with seed {}: {} triangles, {} objects\n", scenario.world.type, scenario.seed_of_world(),
             scene.num_triangles(), scene.objects.size());
  for (const auto& path : written) fmt::print("  {}\n", path.string());
}

}  // namespace

void add_world(CLI::App& app) {
  auto options = std::make_shared<WorldOptions>();
  Subcommand command(app, "world", "Export the generated world of a scenario with its truth table");
  options->scenario.add_to(command);
  command.option("--out", options->out, "File to write: .ply or .obj; the table lies beside it",
                 {.value_name = "FILE", .required = true});
  command.flag("-q,--quiet", options->quiet, "Print errors only");
  command.action([options] { export_scenario_world(*options); });
}

}  // namespace swiftlet::tools
