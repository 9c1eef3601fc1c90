// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/follow_guide.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/guidance/guidance_constants.hpp"
#include "core/guidance/path_overlay.hpp"
#include "swiftlet/core/base/vehicle_named.hpp"
#include "swiftlet/core/messages/guiding_path.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/odometry_report.hpp"

namespace swiftlet {
namespace {

/// [m] largest radius of the figure that the guide may request. Larger figures do not improve the estimate of the
/// heading.
constexpr double kFigureMax_m = 1.0;

/// The pose without roll and pitch.
Pose level(const Pose& T_local_body) {
  Pose T = Pose::Identity();
  const double yaw_rad = yaw_of(T_local_body.linear());
  const double s = elementary::sin(yaw_rad), c = elementary::cos(yaw_rad);
  T.linear() << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0;
  T.translation() = T_local_body.translation();
  return T;
}

class FollowGuide : public Guidance {
 public:
  FollowGuide(const FollowGuideConfig& config, const GuidanceSetup& setup)
      : config_(config),
        primary_(vehicle_named(config.primary, setup.agent, "guidance.primary")),
        limits_(setup.limits),
        report_period_(from_seconds(1.0 / config.odometry_rate_hz)) {}

  GuidanceNeeds needs() const override { return {.world = false}; }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    if (!started_) hold(input.estimate.T_local_body);
    started_ = true;
    const bool is_new = listen(input);
    watch_link(input, is_new);
    drop_visited(input.estimate.T_local_body.translation());
    choose_goal(input, output);
    report(input, outbox);
  }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    std::vector<Vector3> points_m = {goal_.position_m};
    for (const Reference& waypoint : path_) points_m.push_back(waypoint.position_m);
    overlays.push_back(path_overlay("guided_path", points_m, 0.1F));
  }

 private:
  /// Time on this vehicle's own clock.
  TimeNs own_time(TimeNs t) const {
    return t + from_seconds(config_.clock.offset_s + 1e-6 * config_.clock.drift_ppm * to_seconds(t));
  }
  TimeNs from_own_time(TimeNs own) const {
    const double rate = 1e-6 * config_.clock.drift_ppm;
    return own - from_seconds((config_.clock.offset_s + rate * to_seconds(own)) / (1.0 + rate));
  }

  /// Processes messages; true if a path was accepted.
  bool listen(const GuidanceInput& input) {
    bool is_new = false;
    for (const Message& message : input.observation.messages) {
      GuidingPath received;
      if (message.from != primary_ || read_message(message, received) != Reading::kDone) continue;
      if (linked_ && received.path <= newest_path_) continue;  // outdated by a later one
      const TimeNs t = received.has_instant ? from_own_time(received.t) : input.estimate.t;
      const Pose* T_local_body = received.has_instant ? pose_at(received.t) : &input.estimate.T_local_body;
      const bool remembered = t >= input.poses[0].t && t <= input.estimate.t;
      if (T_local_body == nullptr && !remembered) continue;  // no pose is known for its time
      take(received, level(T_local_body != nullptr ? *T_local_body : input.poses.at(t)), input.estimate);
      is_new = true;
    }
    return is_new;
  }

  /// Pose of a sent report, by its time stamp on the own clock: over a slow radio, the reply arrives seconds later.
  const Pose* pose_at(TimeNs t) const {
    const auto sent = std::find_if(reported_.begin(), reported_.end(), [t](const Reported& r) { return r.t == t; });
    return sent == reported_.end() ? nullptr : &sent->T_local_body;
  }

  void take(const GuidingPath& received, const Pose& T_local_body, const StateEstimate& estimate) {
    newest_path_ = received.path;
    num_visited_ = 0;
    command_ = received.command;
    moves_within_m_ = received.command == GuidingPath::Command::kMove ? std::min(received.radius_m, kFigureMax_m) : 0.0;
    const bool flew = !path_.empty();
    path_.clear();
    const double yaw_rad = yaw_of(T_local_body.linear());
    for (const GuidingWaypoint& waypoint : received.waypoints) {
      Reference& place = path_.emplace_back();
      place.position_m = T_local_body * waypoint.p_body_m.cast<double>();
      place.yaw_rad = std::remainder(yaw_rad + static_cast<double>(waypoint.yaw_rad), 2.0 * std::numbers::pi);
    }
    skip_passed(estimate.T_local_body.translation(), T_local_body.translation());
    if (path_.empty() && (flew || !was_guided_)) stop(estimate);
    was_guided_ = true;
  }

  /// Skips legs that were passed during the delay of the path, so that a delayed path does not turn the vehicle back.
  /// At most the distance flown since then is skipped.
  void skip_passed(const Vector3& p_local_m, const Vector3& then_local_m) {
    if (path_.empty()) return;
    const double flown_m = (p_local_m - then_local_m).norm();
    double least_m = config_.visited_m, ahead_m = (path_.front().position_m - then_local_m).norm();
    std::size_t passed = 0;
    for (std::size_t i = 0; i + 1 < path_.size() && ahead_m < flown_m; ++i) {
      const Vector3& from_m = path_[i].position_m;
      const Vector3 leg_m = path_[i + 1].position_m - from_m;
      const double length_sq = std::max(leg_m.squaredNorm(), kSamePlace_m * kSamePlace_m);
      const double share = std::clamp(leg_m.dot(p_local_m - from_m) / length_sq, 0.0, 1.0);
      const double distance_m = (from_m + share * leg_m - p_local_m).norm();
      if (distance_m < least_m) passed = i + 1;
      least_m = std::min(least_m, distance_m);
      ahead_m += leg_m.norm();
    }
    num_visited_ = static_cast<std::uint16_t>(passed);
    path_.erase(path_.begin(), path_.begin() + static_cast<std::ptrdiff_t>(passed));
  }

  void watch_link(const GuidanceInput& input, bool is_new) {
    if (is_new) {
      linked_ = true;
      last_received_ = input.observation.t;
    } else if (linked_ && input.observation.t - last_received_ > from_seconds(config_.link_timeout_s)) {
      linked_ = false;
      lost_ = true;
      path_.clear();
      stop(input.estimate);
    }
    lost_ = lost_ && !linked_;
  }

  void hold(const Pose& T_local_body) {
    goal_ = {};
    goal_.position_m = T_local_body.translation();
    goal_.yaw_rad = yaw_of(T_local_body.linear());
  }

  /// Holds the point of rest after braking.
  void stop(const StateEstimate& estimate) {
    hold(estimate.T_local_body);
    const Vector3& v = estimate.v_local_mps;
    const double speed_mps = elementary::hypot(v.x(), v.y());
    goal_.position_m.head<2>() += v.head<2>() * (0.5 * speed_mps / limits_.horizontal_acceleration_mps2);
    goal_.position_m.z() += v.z() * (0.5 * std::abs(v.z()) / limits_.vertical_acceleration_mps2);
  }

  void drop_visited(const Vector3& p_local_m) {
    while (!path_.empty() && (path_.front().position_m - p_local_m).norm() < config_.visited_m) {
      goal_ = path_.front();  // holds the last one
      path_.erase(path_.begin());
      ++num_visited_;
    }
  }

  void choose_goal(const GuidanceInput& input, GuidanceOutput& output) {
    output.mission = command_ == GuidingPath::Command::kDone     ? MissionStatus::kDone
                     : command_ == GuidingPath::Command::kFailed ? MissionStatus::kFailed
                                                                 : MissionStatus::kEndless;
    output.speed_limit_mps = config_.speed_mps;
    output.goal = path_.empty() ? goal_ : path_.front();
    output.note = lost_                   ? "hovering: link to the guide lost"
                  : !path_.empty()        ? "following the guide"
                  : moves_within_m_ > 0.0 ? "moves, so that its guide finds it"
                  : was_guided_           ? "hovering as commanded by the guide"
                                          : "waiting for the guide";
    if (lost_) return;
    const double radius_m = was_guided_ ? moves_within_m_ : config_.excitation.radius_m;
    if (radius_m > 0.0) excite(radius_m, input.dt_s, output.goal);
  }

  /// Flies a horizontal figure eight through the waiting position.
  void excite(double radius_m, double dt_s, Reference& goal) {
    phase_rad_ = std::remainder(phase_rad_ + dt_s * config_.excitation.speed_mps / (std::numbers::sqrt2 * radius_m),
                                2.0 * std::numbers::pi);
    goal.position_m.x() += radius_m * elementary::sin(phase_rad_);
    goal.position_m.y() += radius_m * elementary::sin(phase_rad_) * elementary::cos(phase_rad_);
  }

  void report(const GuidanceInput& input, Outbox& outbox) {
    const TimeNs t = input.observation.t;
    if (primary_ == kNoVehicle || t < next_report_) return;  // no guide to report to
    next_report_ = std::max(next_report_ + report_period_, t);
    const StateEstimate& e = input.estimate;
    OdometryReport report;
    report.t = own_time(e.t);
    report.T_local_body = e.T_local_body;
    report.v_local_mps = e.v_local_mps;
    report.yaw_rate_radps = (e.T_local_body.linear() * e.omega_body_radps).z();
    report.path = newest_path_;
    report.num_visited = num_visited_;
    write_message(report, outbox.add(primary_));
    reported_[next_reported_] = {report.t, report.T_local_body};
    next_reported_ = (next_reported_ + 1) % reported_.size();
  }

  struct Reported {
    TimeNs t = std::numeric_limits<TimeNs>::min();
    Pose T_local_body = Pose::Identity();
  };

  FollowGuideConfig config_;
  VehicleId primary_;
  MotionLimits limits_;
  TimeNs report_period_;
  bool started_ = false;
  bool linked_ = false, lost_ = false, was_guided_ = false;
  TimeNs last_received_ = 0, next_report_ = 0;
  GuidingPath::Command command_ = GuidingPath::Command::kGuide;
  double moves_within_m_ = 0.0;  // 0: no motion requested
  std::uint32_t newest_path_ = 0;
  std::uint16_t num_visited_ = 0;
  std::array<Reported, 64> reported_;
  std::size_t next_reported_ = 0;
  std::vector<Reference> path_;  // remaining waypoints, in the local frame
  Reference goal_;               // held without a path
  double phase_rad_ = 0.0;
};

}  // namespace

void OwnClockConfig::visit(ConfigVisitor& v) {
  v.field("offset_s", offset_s, "[s] offset of the vehicle's clock at the start; positive: ahead",
          Range::between(-1e6, 1e6));
  v.field("drift_ppm", drift_ppm, "[1e-6] drift of the vehicle's clock; positive: too fast", Range::between(-1e4, 1e4));
}

void ExcitationConfig::visit(ConfigVisitor& v) {
  v.field("radius_m", radius_m, "[m] half the length of the horizontal figure eight; 0: hovers instead",
          Range::between(0.0, 100.0));
  v.field("speed_mps", speed_mps, "[m/s] speed at the center of the figure eight", Range{0.0, 10.0, true});
}

void FollowGuideConfig::visit(ConfigVisitor& v) {
  v.field("primary", primary, "[-] name of the guiding vehicle; empty: the first other vehicle");
  v.field("odometry_rate_hz", odometry_rate_hz, "[Hz] rate of odometry reports to the guide",
          Range::between(0.01, 1000.0));
  v.field("speed_mps", speed_mps, "[m/s] largest horizontal speed, and largest vertical speed", Range::positive());
  v.field("visited_m", visited_m, "[m] distance within which a waypoint counts as visited", Range::positive());
  v.field("link_timeout_s", link_timeout_s, "[s] time without a path from the guide after which the vehicle hovers",
          Range::positive());
  v.object("excitation", excitation, "motion until the first message of the guide");
  v.object("clock", clock, "error of the vehicle's clock");
}

std::unique_ptr<Guidance> make_follow_guide(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<FollowGuide>(dynamic_cast<const FollowGuideConfig&>(config), setup);
}

}  // namespace swiftlet
