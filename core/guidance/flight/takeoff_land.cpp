// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/takeoff_land.hpp"

#include "core/guidance/flight/landing.hpp"

namespace swiftlet {
namespace {

/// [m] distance to the end of the climb below which takeoff is complete. Values below the error of tracking never
/// complete it.
constexpr double kAtHeight_m = 0.2;

class TakeoffLand : public Guidance {
 public:
  TakeoffLand(const TakeoffLandConfig& config, const GuidanceSetup& setup)
      : config_(config), landing_(config.landing_speed_mps) {
    top_.position_m = setup.agent.T_local_body_start.translation() + config.altitude_m * Vector3::UnitZ();
    top_.yaw_rad = yaw_of(setup.agent.T_local_body_start.linear());
  }

  GuidanceNeeds needs() const override { return {.world = false}; }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    if (landed_) return;
    output.goal = top_;
    output.speed_limit_mps = config_.climb_speed_mps;
    output.note = "climbing";
    if ((input.estimate.T_local_body.translation() - top_.position_m).norm() < kAtHeight_m) arrived_ = true;
    if (!arrived_) return;
    output.note = "hovering";
    hovered_s_ += input.dt_s;
    if (hovered_s_ < config_.hover_s) return;
    landed_ = landing_.finish(top_, input, output);
  }

 private:
  TakeoffLandConfig config_;
  Reference top_;
  Landing landing_;
  bool arrived_ = false, landed_ = false;
  double hovered_s_ = 0.0;
};

}  // namespace

void TakeoffLandConfig::visit(ConfigVisitor& v) {
  v.field("altitude_m", altitude_m, "[m] height of the climb above the start", Range::positive());
  v.field("hover_s", hover_s, "[s] time of hovering before the landing", Range::non_negative());
  v.field("climb_speed_mps", climb_speed_mps, "[m/s]", Range::positive());
  v.field("landing_speed_mps", landing_speed_mps, "[m/s]", Range::positive());
}

std::unique_ptr<Guidance> make_takeoff_land(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<TakeoffLand>(dynamic_cast<const TakeoffLandConfig&>(config), setup);
}

}  // namespace swiftlet
