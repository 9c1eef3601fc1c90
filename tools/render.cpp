// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "progress.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/render/snapshot_recorder.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"

namespace swiftlet::tools {
namespace {

namespace fs = std::filesystem;

struct RenderOptions {
  std::string run;
  std::string out;
  std::vector<std::string> cameras;
  std::vector<double> times_s;
  bool video = false;
  double frames_per_s = 25.0;
  double to_s = -1.0;
  double paper_mm = 0.0;
  int threads = 0;
  bool quiet = false;
};

// The run's own cameras, or new ones by type ("top", "follow:uav2").
std::vector<sim::CameraConfig> choose_cameras(const sim::Scenario& scenario, const std::vector<std::string>& wanted) {
  if (wanted.empty() && !scenario.snapshots.empty()) return scenario.snapshots;
  std::vector<sim::CameraConfig> chosen;
  for (const std::string& name : wanted.empty() ? std::vector<std::string>{"follow", "top"} : wanted) {
    const auto known = std::find_if(scenario.snapshots.begin(), scenario.snapshots.end(),
                                    [&](const sim::CameraConfig& camera) { return camera.name == name; });
    if (known != scenario.snapshots.end()) {
      chosen.push_back(*known);
      continue;
    }
    sim::CameraConfig camera;
    const std::size_t colon = name.find(':');
    const std::string type = name.substr(0, colon);
    camera.type = *enum_named<sim::CameraConfig::Type>(type, sim::CameraConfig::kTypes);  // validated by check_options
    if (colon != std::string::npos) camera.vehicle = name.substr(colon + 1);
    camera.name = type + (camera.vehicle.empty() ? "" : "_" + camera.vehicle);
    camera.cloud = sim::CloudColors::kHeight;
    camera.overlays = {"*"};
    chosen.push_back(camera);
  }
  return chosen;
}

// Reports errors in the options, which the scenario's reader would attribute to lines that are not in the file.
void check_options(const RenderOptions& options, const sim::Scenario& scenario) {
  std::vector<std::string> known(std::begin(sim::CameraConfig::kTypes), std::end(sim::CameraConfig::kTypes)), vehicles;
  for (const sim::CameraConfig& camera : scenario.snapshots) known.push_back(camera.name);
  for (const sim::VehicleConfig& vehicle : scenario.vehicles) vehicles.push_back(vehicle.name);
  const auto require = [](const std::string& name, const std::vector<std::string>& of, const std::string& option) {
    if (std::find(of.begin(), of.end(), name) != of.end()) return;
    throw sim::InputError("--camera " + option + ": expected " + sim::one_of(of) + ", found \"" + name + "\"" +
                          sim::did_you_mean(name, of));
  };
  for (const std::string& camera : options.cameras) {
    const std::size_t colon = camera.find(':');
    require(camera.substr(0, colon), known, camera);
    if (colon != std::string::npos) require(camera.substr(colon + 1), vehicles, camera);
  }
  for (const double time_s : options.times_s) {
    if (time_s <= scenario.duration_s) continue;
    throw sim::InputError(
        fmt::format("--time {:g}: expected at most {:g}, the length of the run", time_s, scenario.duration_s));
  }
}

// Repeats the flight of the resolved scenario, which gives the same bits and thus the same views.
void render(const RenderOptions& options) {
  sim::require_pictures("render: ");
  const fs::path run(options.run);
  if (!fs::exists(run / "scenario.yaml")) {
    throw sim::InputError(options.run +
                          ": expected the directory of a finished run (with scenario.yaml and summary.json)");
  }
  sim::Scenario scenario = sim::load_scenario(run / "scenario.yaml");
  scenario.recorders.clear();
  check_options(options, scenario);
  scenario.snapshots = choose_cameras(scenario, options.cameras);
  const double end_s = options.to_s >= 0.0 ? std::min(options.to_s, scenario.duration_s) : scenario.duration_s;
  double last_s = end_s;
  for (sim::CameraConfig& camera : scenario.snapshots) {
    if (options.paper_mm > 0.0) {
      camera.style = sim::PictureMedium::kPaper;
      camera.width_mm = options.paper_mm;
      camera.height_mm = 0.0;
    }
    if (options.video) {
      camera.times_s.clear();
      camera.every_s = 1.0 / options.frames_per_s;
    } else if (!options.times_s.empty()) {
      camera.times_s = options.times_s;
      camera.every_s = 0.0;
      last_s = *std::max_element(options.times_s.begin(), options.times_s.end());
    } else if (camera.times_s.empty() && camera.every_s <= 0.0) {
      camera.times_s = {end_s};
    }
  }
  scenario = sim::validated(scenario);

  const fs::path out = options.out.empty() ? run / "render" : fs::path(options.out);
  options.out.empty() ? sim::make_inner_directory(out) : sim::make_directory(out);
  sim::Simulation simulation(scenario, options.threads);
  if (options.video) {
    simulation.attach(sim::make_video_recorder(scenario.snapshots, options.frames_per_s), out);
  } else {
    simulation.attach_recorders(out);
  }
  {
    Progress progress("render", options.quiet);
    while (!simulation.finished() && to_seconds(simulation.now()) < last_s) {
      simulation.tick();
      const double now_s = to_seconds(simulation.now());
      progress.update(now_s / last_s, fmt::format("{:.1f} of {:g} s", now_s, last_s));
    }
  }
  const std::vector<fs::path> written = simulation.finish();
  if (options.quiet) return;
  for (const fs::path& path : written) fmt::print("{}\n", (out / path).string());
}

}  // namespace

void add_render(CLI::App& app) {
  auto options = std::make_shared<RenderOptions>();
  Subcommand command(app, "render", "Make pictures or a video of a finished run by flying it again, bit for bit");
  command.option("run", options->run, "Directory of a finished run", {.value_name = "RUN_DIR", .required = true});
  command.option("--camera", options->cameras,
                 "Camera of the scenario, or a type with a vehicle: top, follow:uav1, onboard:uav2",
                 {.value_name = "NAME"});
  command.option("--time", options->times_s, "Picture at this time; may be repeated",
                 {.value_name = "SECONDS", .min = 0.0});
  command.flag("--video", options->video, "A video of each camera (needs ffmpeg)");
  command.option("--paper", options->paper_mm, "Width of pictures for a paper: white, without captions, as PNG and SVG",
                 {.value_name = "MILLIMETERS", .min = 10.0, .max = 1000.0});
  command.option("--fps", options->frames_per_s, "Frames per simulated second of a video", {.min = 1.0, .max = 120.0});
  command.option("--until", options->to_s, "End of the video or the last picture",
                 {.value_name = "SECONDS", .min = 0.0});
  command.option("--out", options->out, "Output directory (default: RUN_DIR/render)", {.value_name = "DIR"});
  command.option("--threads", options->threads, "Threads, 0: all", {.min = 0, .max = 1024});
  command.flag("-q,--quiet", options->quiet, "Print errors only");
  command.action([options] { render(*options); });
}

}  // namespace swiftlet::tools
