// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/hover.hpp"

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

class Hover : public Guidance {
 public:
  Hover(const HoverConfig& config, const GuidanceSetup& setup) : at_start_(config.at == HoverConfig::At::kStart) {
    const Pose& T_local_start = setup.agent.T_local_body_start;
    goal_.position_m = at_start_ ? Vector3(T_local_start.translation()) : config.point_m;
    goal_.yaw_rad = at_start_ ? yaw_of(T_local_start.linear()) : radians(config.yaw_deg);
  }

  GuidanceNeeds needs() const override { return {.world = !at_start_}; }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    output.goal = at_start_ ? goal_ : FrameChange::to_local(input.estimate).reference(goal_);
    output.mission = MissionStatus::kEndless;
  }

 private:
  bool at_start_;
  Reference goal_;  // in the local frame for the start, in the world for a point
};

}  // namespace

void HoverConfig::visit(ConfigVisitor& v) {
  v.choice("at", at, {"start", "point"}, "[-] pose to hold: position and heading of the start, or point_m and yaw_deg");
  v.field("point_m", point_m, "[m] world");
  if (at == At::kPoint) v.destinations("point_m", point_m);
  v.field("yaw_deg", yaw_deg, "[deg] heading at the point");
}

std::unique_ptr<Guidance> make_hover(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Hover>(dynamic_cast<const HoverConfig&>(config), setup);
}

}  // namespace swiftlet
