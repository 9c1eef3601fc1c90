// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/interception/target.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "swiftlet/core/control/reference_governor.hpp"
#include "swiftlet/core/guidance/agile.hpp"
#include "swiftlet/core/guidance/trajectory.hpp"
#include "swiftlet/core/guidance/within_limits.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

/// [m] Least distance between successive points of line, random and evasive. Smaller values turn more often.
constexpr double kLegMin_m = 15.0;

struct EvasionTuning {
  double cruise = 0.6;  ///< [-] share of speed_mps while an evasive target does not flee; smaller: easier to intercept
  double min_speed_mps = 0.5;    ///< [m/s] slower velocities give no heading
  double reached_m = 3.0;        ///< [m] distance at which an evasive target reaches its goal
  double turn_gain_per_s = 2.5;  ///< [1/s] gain from the velocity error to acceleration
  double margin_m = 5.0;         ///< [m] distance from the box's sides at which an evasive target turns away
  double jink_period_s = 1.2;    ///< [s] period of random changes of the evasion side
  double jink = 0.7;  ///< [-] lateral part of the evasion velocity, relative to the part away from the pursuer
  double track_timeout_s = 0.7;  ///< [s] older tracks are ignored
};
constexpr EvasionTuning kEvasion;

enum Draw : std::uint32_t { kLegs, kShape, kJinks };

/// A parametric curve through the start; position and derivatives with respect to the angle along it.
struct Curve {
  Vector3 center_m, u_m, w_m;  // half axes
  bool eight = false;

  Reference at(const RampedTravel::State& travel) const {
    // center + u sin s + w cos s for a circle; u sin s + w sin 2s / 2 for a figure eight.
    const double s = travel.s, sine = elementary::sin(s), cosine = elementary::cos(s);
    const Vector3 d =
        eight ? Vector3(cosine * u_m + elementary::cos(2.0 * s) * w_m) : Vector3(cosine * u_m - sine * w_m);
    const Vector3 dd =
        eight ? Vector3(-sine * u_m - 2.0 * elementary::sin(2.0 * s) * w_m) : Vector3(-sine * u_m - cosine * w_m);
    Reference r;
    r.position_m = center_m + sine * u_m + (eight ? 0.5 * elementary::sin(2.0 * s) : cosine) * w_m;
    r.velocity_mps = travel.ds * d;
    r.acceleration_mps2 = travel.dds * d + travel.ds * travel.ds * dd;
    return r;
  }
};

class TargetFlight : public Guidance {
 public:
  TargetFlight(const TargetConfig& config, const GuidanceSetup& setup)
      : config_(config),
        limits_(setup.limits),
        governor_(setup.limits),
        random_(config.seed, "guidance.target"),
        start_local_m_(setup.agent.T_local_body_start.translation()),
        yaw_rad_(yaw_of(setup.agent.T_local_body_start.linear())) {}

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    const FrameChange to_local = FrameChange::to_local(input.estimate),
                      to_world = FrameChange::to_world(input.estimate);
    if (!started_) start(to_world.point(start_local_m_), input.estimate, to_world);
    t_s_ += input.dt_s;
    output.goal_is_feasible = false;
    switch (config_.motion) {
      case TargetConfig::Motion::kHover:
        output.goal.position_m = start_local_m_;
        break;
      case TargetConfig::Motion::kLine:
        output.goal = to_local.reference(line(input.dt_s));
        break;
      case TargetConfig::Motion::kCircle:
      case TargetConfig::Motion::kFigureEight:
        output.goal = to_local.reference(curve_.at(travel_.at(t_s_)));
        break;
      case TargetConfig::Motion::kRandom:
        spline_->advance(input.dt_s);
        output.goal = to_local.reference(spline_->reference());
        break;
      case TargetConfig::Motion::kEvasive:
        output.goal = to_local.reference(evade(input, to_world));
        output.goal_is_feasible = true;
        break;
    }
    turn(output.goal);
    output.mission = MissionStatus::kEndless;
  }

 private:
  void start(const Vector3& start_world_m, const StateEstimate& estimate, const FrameChange& to_world) {
    started_ = true;
    leg_world_m_ = line_world_m_ = start_world_m;
    Reference at_rest;
    at_rest.position_m = start_world_m;
    at_rest.yaw_rad = to_world.yaw(yaw_of(estimate.T_local_body.linear()));
    governor_.reset(at_rest);
    const double a_mps2 = std::min(config_.acceleration_mps2, limits_.horizontal_acceleration_mps2);
    const double ramp_s = RampedTravel::kSteepest * config_.speed_mps / (0.5 * a_mps2);  // half of the acceleration
    if (config_.motion == TargetConfig::Motion::kCircle || config_.motion == TargetConfig::Motion::kFigureEight) {
      make_curve(start_world_m, a_mps2);
      const double rate = config_.speed_mps / curve_.u_m.norm() / (curve_.eight ? 1.42 : 1.0);
      travel_ = RampedTravel(std::numeric_limits<double>::infinity(), rate, ramp_s);
    }
    if (config_.motion == TargetConfig::Motion::kRandom) {
      AgileConfig agile;
      agile.seed = config_.seed;
      agile.speed_max_mps = config_.speed_mps;
      agile.acceleration_max_mps2 = a_mps2;
      agile.area_min_m = config_.area_min_m;
      agile.area_max_m = config_.area_max_m;
      agile.leg_min_m = kLegMin_m;
      spline_.emplace(agile, start_world_m, limits_.vertical_speed_mps, limits_.vertical_acceleration_mps2);
    }
  }

  /// Horizontal curve through the start, with its center towards that of the box, and a random direction and sense.
  void make_curve(const Vector3& start_world_m, double a_mps2) {
    const double least_m = 1.3 * config_.speed_mps * config_.speed_mps / a_mps2;
    const double radius_m = std::max(config_.radius_m, least_m);
    const double sense = random_.uniform(0, kShape) < 0.5 ? -1.0 : 1.0;
    const Vector3 middle_m = 0.5 * (config_.area_min_m + config_.area_max_m);
    Vector3 inward = middle_m - start_world_m;
    inward.z() = 0.0;
    const double heading = 2.0 * kPi * random_.uniform(1, kShape);
    if (inward.norm() < 1.0) inward = Vector3(elementary::cos(heading), elementary::sin(heading), 0.0);
    inward.normalize();
    const Vector3 across(-sense * inward.y(), sense * inward.x(), 0.0);
    curve_.eight = config_.motion == TargetConfig::Motion::kFigureEight;
    if (curve_.eight) {
      curve_ = {start_world_m, radius_m * Vector3(elementary::cos(heading), elementary::sin(heading), 0.0),
                radius_m * Vector3(-sense * elementary::sin(heading), sense * elementary::cos(heading), 0.0), true};
    } else {
      curve_ = {start_world_m + radius_m * inward, radius_m * across, -radius_m * inward, false};
    }
  }

  Vector3 drawn_place() {
    Vector3 place_m = leg_world_m_;
    for (int attempt = 0; attempt < 32; ++attempt) {
      ++num_legs_;
      for (int i = 0; i < 3; ++i) {
        place_m[i] = random_.uniform(config_.area_min_m[i], config_.area_max_m[i], num_legs_,
                                     4 * kLegs + 16 + static_cast<std::uint32_t>(i));
      }
      if ((place_m - leg_world_m_).norm() >= kLegMin_m) break;
    }
    return place_m;
  }

  /// Straight at constant speed from point to point; the reference governor rounds the corners.
  Reference line(double dt_s) {
    double left_m = config_.speed_mps * dt_s;
    while ((leg_world_m_ - line_world_m_).norm() <= left_m) {
      left_m -= (leg_world_m_ - line_world_m_).norm();
      line_world_m_ = leg_world_m_;
      leg_world_m_ = drawn_place();
    }
    const Vector3 direction = (leg_world_m_ - line_world_m_).normalized();
    line_world_m_ += left_m * direction;
    Reference r;
    r.position_m = line_world_m_;
    r.velocity_mps = config_.speed_mps * direction;
    return r;
  }

  /// Flies from point to point at a part of its speed; evades a near pursuer, alternating sides at random.
  Reference evade(const GuidanceInput& input, const FrameChange& to_world) {
    const Vector3 p_m = governor_.state().position_m;
    if ((leg_world_m_ - p_m).norm() < kEvasion.reached_m) leg_world_m_ = drawn_place();
    Vector3 v_mps = kEvasion.cruise * config_.speed_mps * (leg_world_m_ - p_m).normalized();
    const Track* pursuer = nullptr;
    double nearest_m = config_.alarm_m;
    for (const Track& track : input.tracks) {
      if (to_seconds(input.observation.t - track.t) > kEvasion.track_timeout_s) continue;
      const double distance_m = (track.position_m - input.estimate.T_local_body.translation()).norm();
      if (distance_m >= nearest_m) continue;
      nearest_m = distance_m;
      pursuer = &track;
    }
    if (pursuer != nullptr) {
      const Vector3 away = (p_m - to_world.point(pursuer->position_m)).normalized();
      const auto jink = static_cast<std::uint32_t>(t_s_ / kEvasion.jink_period_s);
      const double side = random_.uniform(jink, kJinks + 64) < 0.5 ? -1.0 : 1.0;
      const Vector3 across(-side * away.y(), side * away.x(), random_.uniform(-0.5, 0.5, jink, kJinks + 65));
      v_mps = config_.speed_mps * (away + kEvasion.jink * across).normalized();
    }
    // Turns along the sides of the box instead of into them.
    for (int i = 0; i < 3; ++i) {
      const double to_min_m = p_m[i] - config_.area_min_m[i], to_max_m = config_.area_max_m[i] - p_m[i];
      const double margin_m = std::min(kEvasion.margin_m, 0.3 * (config_.area_max_m[i] - config_.area_min_m[i]));
      if (to_min_m < margin_m) v_mps[i] = std::max(v_mps[i], config_.speed_mps * (1.0 - 2.0 * to_min_m / margin_m));
      if (to_max_m < margin_m) v_mps[i] = std::min(v_mps[i], -config_.speed_mps * (1.0 - 2.0 * to_max_m / margin_m));
    }
    if (v_mps.norm() > config_.speed_mps) v_mps *= config_.speed_mps / v_mps.norm();
    const double a_max = std::min(config_.acceleration_mps2, limits_.horizontal_acceleration_mps2);
    Vector3 a_mps2 = kEvasion.turn_gain_per_s * (v_mps - governor_.state().velocity_mps);
    if (a_mps2.norm() > a_max) a_mps2 *= a_max / a_mps2.norm();
    return governor_.accelerate(a_mps2, governor_.state().yaw_rad, input.dt_s);
  }

  void turn(Reference& goal) {
    if (goal.velocity_mps.head<2>().norm() > kEvasion.min_speed_mps)
      yaw_rad_ = elementary::atan2(goal.velocity_mps.y(), goal.velocity_mps.x());
    goal.yaw_rad = yaw_rad_;
    goal.yaw_rate_radps = 0.0;
  }

  TargetConfig config_;
  MotionLimits limits_;
  ReferenceGovernor governor_;  // used by evasive targets, in the world
  Random random_;
  Vector3 start_local_m_;
  double yaw_rad_;  // in the local frame
  bool started_ = false;
  double t_s_ = 0.0;
  Curve curve_;
  RampedTravel travel_;
  std::optional<AgileSpline> spline_;
  Vector3 line_world_m_ = Vector3::Zero(), leg_world_m_ = Vector3::Zero();
  std::uint32_t num_legs_ = 0;
};

}  // namespace

void TargetConfig::visit(ConfigVisitor& v) {
  v.choice(
      "motion", motion, {"hover", "line", "circle", "figure_eight", "random", "evasive"},
      "[-] hover at the start; straight from point to point; a curve through the start; random smooth flight; away "
      "from objects that the tracker follows");
  v.field("seed", seed, "[-] random seed of the flight");
  v.field("speed_mps", speed_mps, "[m/s] largest speed", Range::positive());
  v.field("acceleration_mps2", acceleration_mps2, "[m/s^2] largest acceleration", Range::positive());
  v.field("area_min_m", area_min_m, "[m] corner of smallest coordinates of the box of the flight, world frame");
  v.field("area_max_m", area_max_m, "[m] corner of largest coordinates of that box, world frame");
  v.field("radius_m", radius_m, "[m] radius of circle and figure eight; larger if the speed requires it",
          Range::positive());
  v.field("alarm_m", alarm_m, "[m] distance below which an evasive target flees from a track", Range::non_negative());
  v.check((area_max_m.array() > area_min_m.array()).all(), "area_max_m", "more than area_min_m in each direction");
}

std::unique_ptr<Guidance> make_target(const ModuleConfig& config_in, const GuidanceSetup& setup) {
  const auto& config = dynamic_cast<const TargetConfig&>(config_in);
  expect_within("target", setup.limits, "speed_mps", config.speed_mps, "acceleration_mps2", config.acceleration_mps2);
  return std::make_unique<TargetFlight>(config, setup);
}

}  // namespace swiftlet
