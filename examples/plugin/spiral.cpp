// SPDX-License-Identifier: BSD-3-Clause
// Custom guidance in a shared library: a helical climb around the vehicle's start. A scenario loads it by `plugins:
// [libspiral.so]`.
#include "spiral.hpp"

#include "swiftlet/sim/plugin/plugin.hpp"

namespace {

using namespace swiftlet;

struct SpiralConfig : ModuleConfigOf<SpiralConfig> {
  double radius_m = 3.0;
  double speed_mps = 1.5;
  double climb_mps = 0.3;

  void visit(ConfigVisitor& v) override {
    v.field("radius_m", radius_m, "[m] horizontal radius of the helix", Range::positive());
    v.field("speed_mps", speed_mps, "[m/s] horizontal speed", Range::positive());
    v.field("climb_mps", climb_mps, "[m/s] climb rate", Range::non_negative());
  }
};

class Spiral : public Guidance {
 public:
  Spiral(const SpiralConfig& config, const AgentSetup& setup)
      : config_(config), start_local_m_(setup.T_local_body_start.translation()) {}

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    t_s_ += input.dt_s;
    const double angle_rad = config_.speed_mps / config_.radius_m * t_s_;
    const Vector3 outward(elementary::cos(angle_rad), elementary::sin(angle_rad), 0.0);
    output.goal.position_m =
        start_local_m_ + config_.radius_m * (outward - Vector3::UnitX()) + config_.climb_mps * t_s_ * Vector3::UnitZ();
    output.goal.yaw_rad = 0.0;
    output.mission = MissionStatus::kEndless;
  }

 private:
  SpiralConfig config_;
  Vector3 start_local_m_;
  double t_s_ = 0.0;
};

std::unique_ptr<Guidance> make_spiral(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Spiral>(dynamic_cast<const SpiralConfig&>(config), setup.agent);
}

}  // namespace

GuidanceType spiral() { return {{"spiral", "climbs around its start", make_module_config<SpiralConfig>}, make_spiral}; }

SWIFTLET_PLUGIN(registries) { registries.guidances.add(spiral()); }
