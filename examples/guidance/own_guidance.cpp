// SPDX-License-Identifier: BSD-3-Clause
// Custom guidance: a circle around a point of the world. All other stages of the vehicle are built in, and the scenario
// selects this one by its name, like any other. Usage: own_guidance orbit.yaml
#include <cmath>
#include <cstdio>

#include "swiftlet/core/stage_tables/guidances.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace {

using namespace swiftlet;

/// One `visit` serves reader, writer and reference.
struct OrbitConfig : ModuleConfigOf<OrbitConfig> {
  Eigen::Vector3d center_m = {0.0, 0.0, 3.0};
  double radius_m = 5.0;
  double speed_mps = 2.0;

  void visit(ConfigVisitor& v) override {
    v.field("center_m", center_m, "[m] center of the circle, world");
    v.field("radius_m", radius_m, "[m] radius of the circle", Range::positive());
    v.field("speed_mps", speed_mps, "[m/s] speed along the circle", Range::positive());
  }
};

class Orbit : public Guidance {
 public:
  explicit Orbit(const OrbitConfig& config) : config_(config) {}

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    angle_rad_ += config_.speed_mps / config_.radius_m * input.dt_s;
    const Vector3 outward(elementary::cos(angle_rad_), elementary::sin(angle_rad_), 0.0);
    const Vector3 along(-outward.y(), outward.x(), 0.0);
    Reference goal_world;
    goal_world.position_m = config_.center_m + config_.radius_m * outward;
    goal_world.velocity_mps = config_.speed_mps * along;
    goal_world.acceleration_mps2 = -config_.speed_mps * config_.speed_mps / config_.radius_m * outward;
    goal_world.yaw_rad = elementary::atan2(-outward.y(), -outward.x());  // heading towards the center
    // Stages work in the vehicle's local frame. The correction between local and world frame may change at any time.
    output.goal = FrameChange::to_local(input.estimate).reference(goal_world);
    output.mission = MissionStatus::kEndless;
  }

 private:
  OrbitConfig config_;
  double angle_rad_ = 0.0;
};

std::unique_ptr<Guidance> make_orbit(const ModuleConfig& config, const GuidanceSetup&) {
  return std::make_unique<Orbit>(dynamic_cast<const OrbitConfig&>(config));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: own_guidance SCENARIO\n");
    return 2;
  }
  guidance_registry().add({{"orbit", "circles around a point", make_module_config<OrbitConfig>}, make_orbit});
  try {
    sim::Simulation simulation(sim::load_scenario(argv[1]));
    double worst_m = 0.0;
    while (!simulation.finished()) {
      simulation.tick();
      const Vector3& p_world_m = simulation.view().states[0].p_world_m;
      if (to_seconds(simulation.now()) > 10.0) worst_m = std::max(worst_m, std::abs(p_world_m.head<2>().norm() - 4.0));
    }
    std::printf("orbit: at most %.3f m off the circle after 10 s\n", worst_m);
    return worst_m < 0.3 ? 0 : 1;
  } catch (const sim::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
