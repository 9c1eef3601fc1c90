// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/hover.hpp"

#include <numbers>

namespace swiftlet {
namespace {

class Hover : public Guidance {
 public:
  Hover(const HoverConfig& config, const GuidanceSetup& setup) {
    const Pose& T_world_start = setup.agent.T_world_body_start;
    const bool at_start = config.at == "start";
    goal_.position_m = at_start ? Vector3(T_world_start.translation()) : config.point_m;
    goal_.yaw_rad = at_start ? yaw_of(T_world_start.linear()) : config.yaw_deg * std::numbers::pi / 180.0;
  }

  void step(const GuidanceInput&, GuidanceOutput& output) override {
    output.goal = goal_;
    output.mission = MissionStatus::kEndless;
  }

 private:
  Reference goal_;
};

}  // namespace

void HoverConfig::visit(ConfigVisitor& v) {
  v.choice("at", at, {"start", "point"}, "[-] where: the place and heading of the start, or point_m and yaw_deg");
  v.field("point_m", point_m, "[m] world");
  v.field("yaw_deg", yaw_deg, "[deg] heading at the point");
}

std::unique_ptr<Guidance> make_hover(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Hover>(dynamic_cast<const HoverConfig&>(config), setup);
}

}  // namespace swiftlet
