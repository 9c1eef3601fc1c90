// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/guidance/guidance_constants.hpp"
#include "core/guidance/heading.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [m/s] speed at the start of the trajectory below which its flight begins. Smaller values delay the beginning, larger
/// ones begin with an error of tracking.
constexpr double kAtStart_mps = 0.3;
/// [m/s] slowest velocity that gives a heading. Smaller values turn the vehicle about at the ends of a line.
constexpr double kSlowestLeg_mps = 0.1;

/// A point of a curve and its derivatives with respect to the parameter.
struct CurvePoint {
  Vector3 p, dp, ddp;
};

CurvePoint circle(const TrajectoryConfig& c, double s) {
  const double sense = c.clockwise ? -1.0 : 1.0;
  const double angle = radians(c.phase_deg) + sense * s;
  const Vector3 out(elementary::cos(angle), elementary::sin(angle), 0.0);
  const Vector3 along(-sense * out.y(), sense * out.x(), 0.0);
  return {c.center_m + c.radius_m * out, c.radius_m * along, -c.radius_m * out};
}

CurvePoint lissajous(const TrajectoryConfig& c, double s) {
  CurvePoint point;
  for (int i = 0; i < 3; ++i) {
    const double k = c.frequency_ratio[i];
    const double angle = k * (s + radians(c.phase_deg));
    point.p[i] = c.center_m[i] + c.amplitude_m[i] * elementary::sin(angle);
    point.dp[i] = c.amplitude_m[i] * k * elementary::cos(angle);
    point.ddp[i] = -c.amplitude_m[i] * k * k * elementary::sin(angle);
  }
  return point;
}

void require(bool ok, const std::string& what, double found, double limit) {
  if (ok) return;
  throw std::invalid_argument("guidance trajectory: expected " + what + " of at most " + std::to_string(limit) +
                              " (control.limits), found " + std::to_string(found));
}

class Trajectory : public Guidance {
 public:
  Trajectory(const TrajectoryConfig& config, const GuidanceSetup& setup) : config_(config) {
    // Ramps use half of the acceleration.
    const double ramp_s =
        RampedTravel::kSteepest * config.speed_mps / (0.5 * setup.limits.horizontal_acceleration_mps2);
    if (config.shape == TrajectoryConfig::Shape::kLine) {
      direction_ = (config.to_m - config.from_m).normalized();
      const double length = (config.to_m - config.from_m).norm();
      travel_ = RampedTravel(length, config.speed_mps, ramp_s);
      require_within(setup.limits, travel_.speed * direction_,
                     RampedTravel::kSteepest * travel_.speed / ramp_s * direction_);
    } else {
      const double rate = parameter_rate();
      const double length = config.laps > 0 ? 2.0 * kPi * config.laps : std::numeric_limits<double>::infinity();
      travel_ = RampedTravel(length, rate, ramp_s);
      if (config.shape == TrajectoryConfig::Shape::kCircle) {
        require_within(setup.limits, {config.speed_mps, 0.0, 0.0}, {rate * config.speed_mps, 0.0, 0.0});
      } else {
        const Vector3 v = rate * config.amplitude_m.cwiseProduct(config.frequency_ratio);
        require_within(setup.limits, v, rate * v.cwiseProduct(config.frequency_ratio));
      }
    }
    yaw_rad_ = yaw_of(setup.agent.T_local_body_start.linear());
  }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    const Vector3 p_m = input.estimate.T_local_body.translation();
    const FrameChange to_local = FrameChange::to_local(input.estimate);
    if (!flying_) {
      output.goal = at(0.0, to_local);
      output.note = "flying to the start of the trajectory";
      flying_ = (p_m - output.goal.position_m).norm() < kArrived_m && input.estimate.v_local_mps.norm() < kAtStart_mps;
      if (flying_) output.note = "";
      return;
    }
    t_s_ += input.dt_s;
    output.goal = at(t_s_, to_local);
    if (config_.laps == 0) output.mission = MissionStatus::kEndless;
    if (config_.laps > 0 && t_s_ >= laps_duration_s()) output.mission = MissionStatus::kDone;
  }

 private:
  /// Rate of the parameter at which the greatest speed along the curve is speed_mps.
  double parameter_rate() const {
    if (config_.shape == TrajectoryConfig::Shape::kCircle) return config_.speed_mps / config_.radius_m;
    return config_.speed_mps / config_.amplitude_m.cwiseProduct(config_.frequency_ratio).norm();
  }

  /// Checks bounds on speed and acceleration that combine the maxima of the axes.
  static void require_within(const MotionLimits& limits, const Vector3& v, const Vector3& a) {
    const double slack = 1.0 + kNegligible;
    require(v.head<2>().norm() <= slack * limits.horizontal_speed_mps, "a horizontal speed in m/s", v.head<2>().norm(),
            limits.horizontal_speed_mps);
    require(a.head<2>().norm() <= slack * limits.horizontal_acceleration_mps2, "a horizontal acceleration in m/s^2",
            a.head<2>().norm(), limits.horizontal_acceleration_mps2);
    require(std::abs(v.z()) <= slack * limits.vertical_speed_mps, "a vertical speed in m/s", std::abs(v.z()),
            limits.vertical_speed_mps);
    require(std::abs(a.z()) <= slack * limits.vertical_acceleration_mps2, "a vertical acceleration in m/s^2",
            std::abs(a.z()), limits.vertical_acceleration_mps2);
  }

  double laps_duration_s() const {
    return config_.shape == TrajectoryConfig::Shape::kLine ? 2.0 * config_.laps * travel_.duration_s()
                                                           : travel_.duration_s();
  }

  Reference at(double t_s, const FrameChange& to_local) {
    Reference r;
    if (config_.shape == TrajectoryConfig::Shape::kLine) {
      if (config_.laps > 0) t_s = std::min(t_s, laps_duration_s());
      const double leg = std::floor(t_s / travel_.duration_s());
      const bool back = std::fmod(leg, 2.0) == 1.0;
      const auto [s, ds, dds] = travel_.at(t_s - leg * travel_.duration_s());
      const double sense = back ? -1.0 : 1.0;
      r.position_m = (back ? config_.to_m : config_.from_m) + sense * s * direction_;
      r.velocity_mps = sense * ds * direction_;
      r.acceleration_mps2 = sense * dds * direction_;
    } else {
      const auto [s, ds, dds] = travel_.at(t_s);
      const CurvePoint c =
          config_.shape == TrajectoryConfig::Shape::kCircle ? circle(config_, s) : lissajous(config_, s);
      r.position_m = c.p;
      r.velocity_mps = ds * c.dp;
      r.acceleration_mps2 = ds * ds * c.ddp + dds * c.dp;
    }
    r = to_local.reference(r);
    if (config_.yaw == TrajectoryConfig::Yaw::kAlongPath)
      turn_along_velocity(kSlowestLeg_mps, yaw_rad_, r);
    else
      yaw_rad_ = to_local.yaw(radians(config_.yaw_deg));
    r.yaw_rad = yaw_rad_;
    return r;
  }

  TrajectoryConfig config_;
  RampedTravel travel_;
  Vector3 direction_ = Vector3::Zero();  // direction of a line
  double yaw_rad_ = 0.0;                 // in the local frame
  double t_s_ = 0.0;
  bool flying_ = false;
};

}  // namespace

RampedTravel::RampedTravel(double length_in, double speed_in, double ramp_s_in)
    : length(length_in), speed(std::min(speed_in, length_in / ramp_s_in)), ramp_s(ramp_s_in) {}

RampedTravel::State RampedTravel::at(double t_s) const {
  // Speed rises as the quintic step x^3 (10 - 15 x + 6 x^2), whose integral is x^4 (2.5 - 3 x + x^2).
  const auto ramp = [&](double t) {
    const double x = std::clamp(t / ramp_s, 0.0, 1.0);
    const double x2 = x * x;
    return State{speed * ramp_s * x2 * x2 * (2.5 - 3.0 * x + x2) + speed * std::max(t - ramp_s, 0.0),
                 speed * x2 * x * (10.0 - 15.0 * x + 6.0 * x2), speed / ramp_s * 30.0 * x2 * (1.0 - x) * (1.0 - x)};
  };
  if (std::isinf(length)) return ramp(t_s);
  const double t_end = duration_s();
  if (t_s >= t_end) return {length, 0.0, 0.0};
  if (t_s <= 0.5 * t_end) return ramp(t_s);
  const State mirrored = ramp(t_end - t_s);
  return {length - mirrored.s, mirrored.ds, -mirrored.dds};
}

void TrajectoryConfig::visit(ConfigVisitor& v) {
  v.choice("shape", shape, {"circle", "lissajous", "line"},
           "[-] circle; lissajous: center_m + amplitude_m sin(frequency_ratio s); line: from_m to to_m and back");
  v.field("speed_mps", speed_mps, "[m/s] greatest speed along the curve", Range::positive());
  v.field("laps", laps,
          "[-] number of laps before it stops and is done; 0: without end. A lap of a line is there and back",
          Range::non_negative());
  v.field("center_m", center_m, "[m] center of circle and lissajous");
  v.field("radius_m", radius_m, "[m] radius of the circle", Range::positive());
  v.field("phase_deg", phase_deg, "[deg] phase at which circle and lissajous begin");
  v.field("clockwise", clockwise, "[-] sense of the circle seen from above");
  v.field("amplitude_m", amplitude_m, "[m] amplitude of the lissajous curve per axis");
  v.field("frequency_ratio", frequency_ratio, "[-] frequencies of the lissajous curve per axis; 1, 2: a figure eight");
  v.field("from_m", from_m, "[m] beginning of the line");
  v.field("to_m", to_m, "[m] end of the line");
  if (shape == Shape::kLine) {
    v.destinations("from_m", from_m);
    v.destinations("to_m", to_m);
  }
  v.choice("yaw", yaw, {"along_path", "fixed"}, "[-] heading: along the velocity, or yaw_deg");
  v.field("yaw_deg", yaw_deg, "[deg] heading, if the choice is fixed");
  v.check(amplitude_m.cwiseProduct(frequency_ratio).norm() > 0.0, "amplitude_m",
          "an amplitude with a frequency, not all 0");
  v.check((to_m - from_m).norm() > 0.0, "to_m", "another point than from_m");
}

std::unique_ptr<Guidance> make_trajectory(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Trajectory>(dynamic_cast<const TrajectoryConfig&>(config), setup);
}

}  // namespace swiftlet
