// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/waypoints.hpp"

#include "core/guidance/flight/landing.hpp"
#include "core/guidance/guidance_constants.hpp"
#include "core/guidance/heading.hpp"
#include "core/guidance/path_overlay.hpp"
#include "swiftlet/core/guidance/kept_apart.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [m/s] Speed of descent at the end of the flight. Larger values land sooner and touch down harder.
constexpr double kLandingSpeed_mps = 0.5;

class Waypoints : public Guidance {
 public:
  Waypoints(const WaypointsConfig& config, const GuidanceSetup& setup) : config_(config), landing_(kLandingSpeed_mps) {
    const Pose& T_local_start = setup.agent.T_local_body_start;
    const double start_yaw = yaw_of(T_local_start.linear());
    leg_start_m_ = T_local_start.translation();
    goal_.yaw_rad = start_yaw;
    goal_.position_m = leg_start_m_;
    // Waypoints in the start frame turn with its heading only, and lie in the local frame.
    const Eigen::AngleAxisd turn(start_yaw, Vector3::UnitZ());
    if (config.frame != WaypointsConfig::Frame::kStart) return;
    for (Vector3& p : config_.waypoints_m) p = Vector3(leg_start_m_ + turn * p);
  }

  GuidanceNeeds needs() const override { return {.world = config_.frame == WaypointsConfig::Frame::kWorld}; }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    if (landed_) return;
    if (config_.loop) output.mission = MissionStatus::kEndless;
    output.speed_limit_mps = config_.speed_mps;
    const Vector3 p_m = input.estimate.T_local_body.translation();
    to_local_ = FrameChange::to_local(input.estimate);
    if (!config_.waypoints_m.empty()) goal_.position_m = waypoint_m(next_);
    if (!finished_) advance(p_m, input.dt_s);
    face(p_m);
    output.goal = goal_;
    if (finished_) finish(input, output);
  }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    std::vector<Vector3> points_m;
    for (std::size_t i = 0; i < config_.waypoints_m.size(); ++i) points_m.push_back(waypoint_m(i));
    overlays.push_back(path_overlay("waypoints", points_m, 0.15F));
  }

 private:
  Vector3 waypoint_m(std::size_t i) const {
    return config_.frame == WaypointsConfig::Frame::kWorld ? to_local_.point(config_.waypoints_m[i])
                                                           : config_.waypoints_m[i];
  }

  void advance(const Vector3& p_m, double dt_s) {
    if (next_ >= config_.waypoints_m.size()) {  // no waypoints
      finished_ = true;
      return;
    }
    if ((p_m - goal_.position_m).norm() <= config_.arrival_radius_m) arrived_ = true;
    if (!arrived_) return;
    dwelled_s_ += dt_s;
    if (dwelled_s_ < config_.dwell_s) return;
    const bool last = next_ + 1 == config_.waypoints_m.size();
    if (last && !config_.loop) {
      finished_ = true;
      return;
    }
    leg_start_m_ = goal_.position_m;
    next_ = last ? 0 : next_ + 1;
    goal_.position_m = waypoint_m(next_);
    arrived_ = false;
    dwelled_s_ = 0.0;
  }

  void face(const Vector3& p_m) {
    if (config_.yaw == WaypointsConfig::Yaw::kFixed) goal_.yaw_rad = to_local_.yaw(radians(config_.yaw_deg));
    if (config_.yaw == WaypointsConfig::Yaw::kFixed || arrived_) return;
    const Vector3& from = config_.yaw == WaypointsConfig::Yaw::kAlongPath ? leg_start_m_ : p_m;
    goal_.yaw_rad = heading_along(goal_.position_m - from, kShortestToFace_m, goal_.yaw_rad);
  }

  void finish(const GuidanceInput& input, GuidanceOutput& output) {
    if (!config_.land_at_end) {
      output.mission = MissionStatus::kDone;
      return;
    }
    landed_ = landing_.finish(goal_, input, output);
  }

  WaypointsConfig config_;
  Landing landing_;
  Reference goal_;
  FrameChange to_local_;  // from this tick's input
  Vector3 leg_start_m_;
  std::size_t next_ = 0;
  bool arrived_ = false, finished_ = false, landed_ = false;
  double dwelled_s_ = 0.0;
};

}  // namespace

void WaypointsConfig::visit(ConfigVisitor& v) {
  v.field("waypoints_m", waypoints_m, "[m] positions to visit, in order");
  v.check(!waypoints_m.empty(), "waypoints_m", "at least one waypoint");
  v.choice("frame", frame, {"world", "start"},
           "[-] frame of the waypoints; start: origin and heading of the vehicle's start");
  if (frame == Frame::kWorld) v.destinations("waypoints_m", waypoints_m);
  v.field("speed_mps", speed_mps, "[m/s] largest horizontal speed, and largest vertical speed", Range::positive());
  v.field("arrival_radius_m", arrival_radius_m, "[m] distance within which a waypoint counts as visited",
          Range::positive());
  v.field("dwell_s", dwell_s, "[s] time of hovering at each waypoint", Range::non_negative());
  v.field("loop", loop, "[-] whether the first waypoint follows the last");
  v.field("land_at_end", land_at_end, "[-] whether the vehicle lands at the last waypoint and stops the motors");
  v.choice("yaw", yaw, {"along_path", "at_next", "fixed"},
           "[-] heading: along the leg, at the next waypoint as seen from the vehicle, or yaw_deg");
  v.field("yaw_deg", yaw_deg, "[deg] heading, if the choice is fixed");
  v.object("separation", separation, "separation from neighbors, in addition to the avoidance of the guidance itself");
  v.check(!(loop && land_at_end), "land_at_end", "false together with loop, which has no end");
}

std::unique_ptr<Guidance> make_waypoints(const ModuleConfig& config, const GuidanceSetup& setup) {
  const auto& waypoints = dynamic_cast<const WaypointsConfig&>(config);
  return kept_apart(std::make_unique<Waypoints>(waypoints, setup), waypoints.separation, setup);
}

}  // namespace swiftlet
