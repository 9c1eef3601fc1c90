// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/timed_path.hpp"

#include <cmath>

#include "core/guidance/heading.hpp"
#include "core/guidance/path_overlay.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [m/s] slowest velocity that gives a heading. Smaller values turn a nearly resting vehicle about.
constexpr double kSlowestTimed_mps = 0.2;

class TimedPath : public Guidance {
 public:
  TimedPath(const TimedPathConfig& config, const GuidanceSetup& setup)
      : config_(config), stays_(config.points_m.empty()) {
    if (stays_) config_.points_m.push_back(setup.agent.T_local_body_start.translation());
    path_ = UniformSpline(config_.points_m, config_.interval_s);
    yaw_rad_ = yaw_of(setup.agent.T_local_body_start.linear());
  }

  GuidanceNeeds needs() const override { return {.world = !stays_}; }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    t_s_ += input.dt_s;
    const auto [p_m, v_mps, a_mps2] = path_.at(t_s_);
    to_local_ = stays_ ? FrameChange() : FrameChange::to_local(input.estimate);
    output.goal = to_local_.reference({.position_m = p_m, .velocity_mps = v_mps, .acceleration_mps2 = a_mps2});
    if (config_.yaw == TimedPathConfig::Yaw::kAlongPath)
      turn_along_velocity(kSlowestTimed_mps, yaw_rad_, output.goal);
    else
      yaw_rad_ = to_local_.yaw(radians(config_.yaw_deg));
    output.goal.yaw_rad = yaw_rad_;
    if (t_s_ >= path_.duration_s()) output.mission = MissionStatus::kDone;
  }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    std::vector<Vector3> points_m = config_.points_m;
    for (Vector3& p : points_m) p = to_local_.point(p);
    overlays.push_back(path_overlay("path", points_m, 0.05F));
  }

 private:
  TimedPathConfig config_;
  bool stays_;  // no path was given: stays at the start
  UniformSpline path_;
  FrameChange to_local_;  // from this tick's input
  double yaw_rad_ = 0.0;  // in the local frame
  double t_s_ = 0.0;
};

}  // namespace

void TimedPathConfig::visit(ConfigVisitor& v) {
  v.field("points_m", points_m, "[m] control points of the spline, world frame; it begins at the first");
  v.field("interval_s", interval_s, "[s] time between control points", Range{1e-3, 1e6});
  v.choice("yaw", yaw, {"along_path", "fixed"}, "[-] heading: along the velocity, or yaw_deg");
  v.field("yaw_deg", yaw_deg, "[deg] heading, if the choice is fixed");
}

std::unique_ptr<Guidance> make_timed_path(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<TimedPath>(dynamic_cast<const TimedPathConfig&>(config), setup);
}

}  // namespace swiftlet
