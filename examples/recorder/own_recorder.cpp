// SPDX-License-Identifier: BSD-3-Clause
// A custom recorder: top view of the paths of all vehicles as one SVG drawing.
// Usage: own_recorder plan.yaml DIRECTORY
#include <cstdio>

#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace {

using namespace swiftlet;

/// OutputProvider lets the scenario check that no two recorders write the same file.
struct PlanConfig : ModuleConfigOf<PlanConfig>, sim::OutputProvider {
  std::string file = "plan.svg";
  double every_s = 0.1;

  void visit(ConfigVisitor& v) override {
    v.field("file", file, "[-] output file, relative to the run directory");
    v.field("every_s", every_s, "[s] time between path points", Range::positive());
  }
  sim::RecorderOutput output() const override { return {"file", file, true, "plan", {}, {}}; }
};

class PlanRecorder : public sim::Recorder {
 public:
  explicit PlanRecorder(PlanConfig config) : config_(std::move(config)) {}

  void begin(const sim::RunInfo& info) override {
    info_ = info;
    paths_.resize(info.vehicle_names.size());
  }

  /// Called once per tick with truth, sensor data and actions, after all parallel work of the tick.
  void write(const sim::TickView& tick) override {
    if (tick.t < next_) return;
    next_ = tick.t + from_seconds(config_.every_s);
    for (std::size_t i = 0; i < paths_.size(); ++i) {
      const Vector3& p_world_m = tick.states[i].p_world_m;
      char point[64];
      std::snprintf(point, sizeof point, "%.2f,%.2f ", p_world_m.x(), -p_world_m.y());  // the y axis of SVG points down
      paths_[i] += point;
      seen_m_.extend(p_world_m.head<2>());
    }
  }

  std::vector<std::filesystem::path> finish() override {
    sim::write_file(info_.directory / config_.file, drawing());
    return {config_.file};
  }

 private:
  std::string drawing() const {
    const Eigen::Vector2d corner_m = seen_m_.min().array() - 2.0, size_m = seen_m_.sizes().array() + 4.0;
    char view[128];
    std::snprintf(view, sizeof view, "viewBox=\"%.1f %.1f %.1f %.1f\"", corner_m.x(), -corner_m.y() - size_m.y(),
                  size_m.x(), size_m.y());
    std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"800\" " + std::string(view) + ">\n";
    for (std::size_t i = 0; i < paths_.size(); ++i) {
      svg += "<polyline fill=\"none\" stroke-width=\"0.1\" stroke=\"hsl(" + std::to_string(i * 360 / paths_.size()) +
             ",80%,40%)\" points=\"" + paths_[i] + "\"><title>" + info_.vehicle_names[i] + "</title></polyline>\n";
    }
    return svg + "</svg>\n";
  }

  PlanConfig config_;
  sim::RunInfo info_;
  TimeNs next_ = 0;
  std::vector<std::string> paths_;  // indexed by vehicle
  Eigen::AlignedBox2d seen_m_;
};

std::unique_ptr<sim::Recorder> make_plan_recorder(const ModuleConfig& config) {
  return std::make_unique<PlanRecorder>(dynamic_cast<const PlanConfig&>(config));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: own_recorder SCENARIO DIRECTORY\n");
    return 2;
  }
  sim::recorder_registry().add(
      {{"plan", "paths from above as SVG", make_module_config<PlanConfig>}, make_plan_recorder});
  try {
    sim::Simulation simulation(sim::load_scenario(argv[1]));
    std::filesystem::create_directories(argv[2]);
    simulation.attach_recorders(argv[2]);
    while (!simulation.finished()) simulation.tick();
    for (const auto& path : simulation.finish()) std::printf("recorder: wrote %s\n", path.c_str());
    return 0;
  } catch (const sim::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
