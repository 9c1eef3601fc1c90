// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <vector>

#include "commands.hpp"
#include "scenario_options.hpp"
#include "scratch_folder.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/world/export.hpp"

namespace swiftlet::tools {
namespace {

struct WorldOptions {
  ScenarioOptions scenario;
  std::string out;
  std::string map;
  std::optional<double> cut_height_m;
  double paper_mm = 0.0;
  bool quiet = false;
};

/// A top view of the whole world.
sim::CameraConfig camera_above(const Eigen::AlignedBox3d& bounds_world_m) {
  constexpr double kMargin = 1.05;
  sim::CameraConfig camera;
  camera.name = "map";
  camera.times_s = {0.0};
  camera.vehicle_scale = 3.0;
  if (bounds_world_m.isEmpty()) return camera;  // shows only the vehicles
  camera.target_m = bounds_world_m.center();
  const Vector3 size_m = bounds_world_m.sizes();
  camera.width_px = camera.height_px = 1600;
  (size_m.x() > size_m.y() ? camera.height_px : camera.width_px) =
      std::max(400, static_cast<int>(1600.0 * size_m.head<2>().minCoeff() / size_m.head<2>().maxCoeff()));
  camera.span_m = kMargin * std::max(size_m.y(), size_m.x() * camera.height_px / camera.width_px);
  return camera;
}

/// Draws the world and the vehicles' starts, without a flight. For paper it is written as PNG and as SVG.
std::vector<std::filesystem::path> draw_map(const WorldOptions& options, sim::Scenario scenario,
                                            const sim::Scene& scene) {
  const std::filesystem::path file(options.map);
  if (file.extension() != ".png")
    throw sim::InputError(fmt::format("--map {}: expected a name that ends in .png", options.map));
  if (file.has_parent_path()) sim::make_directory(file.parent_path());
  scenario.recorders.clear();
  scenario.snapshots = {camera_above(scene.bounds_m)};
  if (options.cut_height_m) {
    scenario.snapshots[0].cut_above = true;
    scenario.snapshots[0].cut_height_m = *options.cut_height_m;
  }
  if (options.paper_mm > 0.0) {
    scenario.snapshots[0].style = sim::PictureMedium::kPaper;
    scenario.snapshots[0].width_mm = options.paper_mm;
  }
  sim::Simulation simulation(sim::validated(scenario));
  const ScratchFolder scratch;  // created after the long part, since an interrupt ends the program at once
  simulation.attach_recorders(scratch.path());
  simulation.tick();
  std::vector<std::filesystem::path> written;
  for (const auto& picture : simulation.finish()) {
    std::ostringstream content;
    content << std::ifstream(scratch / picture.string(), std::ios::binary).rdbuf();
    written.push_back(std::filesystem::path(file).replace_extension(picture.extension()));
    sim::write_file(written.back(), content.str());
  }
  return written;
}

void export_scenario_world(const WorldOptions& options) {
  if (options.out.empty() && options.map.empty())
    throw sim::InputError("world: expected --out FILE.ply or --map FILE.png, found neither");
  if (options.map.empty() && (options.cut_height_m || options.paper_mm > 0.0))
    throw sim::InputError("world: --cut and --paper are of the map: expected --map FILE.png, found none");
  if (!options.map.empty()) sim::require_pictures("world --map: ");
  const sim::Scenario scenario = options.scenario.load();
  const sim::Scene scene = sim::make_world(scenario.world, scenario.seed_of_world());
  std::vector<std::filesystem::path> written;
  if (!options.out.empty()) {
    const std::filesystem::path out(options.out);
    if (out.has_parent_path()) sim::make_directory(out.parent_path());
    written = sim::export_world(scene, out);
  }
  if (!options.map.empty()) {
    for (auto& picture : draw_map(options, scenario, scene)) written.push_back(std::move(picture));
  }
  if (options.quiet) return;
  fmt::print("{} with seed {}: {} triangles, {} objects\n", scenario.world.type, scenario.seed_of_world(),
             scene.num_triangles(), scene.objects.size());
  fmt::print("{}", sim::to_text(scene.counters));
  for (const auto& path : written) fmt::print("  {}\n", path.string());
}

}  // namespace

void add_world(CLI::App& app) {
  auto options = std::make_shared<WorldOptions>();
  Subcommand command(app, "world", "Export the world of a scenario with its truth table, or draw a map of it");
  options->scenario.add_to(command);
  command.option("--out", options->out, "File to write: .ply or .obj; the table is written beside it",
                 {.value_name = "FILE"});
  command.option("--map", options->map, "Picture to draw: the world from above, with the vehicles at their starts",
                 {.value_name = "FILE.png"});
  command.option("--cut", options->cut_height_m,
                 "Height above which the map omits everything, such as crowns and roofs", {.value_name = "METERS"});
  command.option("--paper", options->paper_mm, "Width of a map for a paper: white, as PNG and SVG",
                 {.value_name = "MILLIMETERS", .min = 10.0, .max = 1000.0});
  command.flag("-q,--quiet", options->quiet, "Print errors only");
  command.action([options] { export_scenario_world(*options); });
}

}  // namespace swiftlet::tools
