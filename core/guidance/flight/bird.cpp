// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/bird.hpp"

#include <algorithm>

#include "core/guidance/flight/endless_flight.hpp"
#include "swiftlet/core/guidance/within_limits.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [m] least distance between targets. Smaller values turn the bird more often.
constexpr double kLeg_m = 6.0;
/// [s] knot interval of the spline. Larger values make wider turns.
constexpr double kKnot_s = 0.25;
/// [-] share of the greatest speed and acceleration during the approach of a perch. Larger values land faster.
constexpr double kLandingPace = 0.5;
/// [m] distance from the perch at which the bird has landed. Larger values begin the stay sooner.
constexpr double kPerched_m = 0.3;
/// [m] amplitude and [Hz] frequency of the height of bounding flight (flapping and folding the wings). Larger values
/// need more vertical acceleration.
constexpr double kBounding_m = 0.03, kBounding_hz = 1.5;
/// [s] mean time of flight before a perch, and on a perch; each time is 0.5 to 1.5 times the mean. Larger values
/// perch less often, and for longer.
constexpr double kFlying_s = 15.0, kPerching_s = 4.0;
/// [s] time for the bounding to grow or to fade. Smaller values need more vertical acceleration.
constexpr double kGrowing_s = 1.0;

AgileConfig spline_of(const BirdConfig& config) {
  AgileConfig spline;
  spline.seed = config.seed;
  spline.speed_max_mps = config.speed_max_mps;
  spline.acceleration_max_mps2 = config.acceleration_max_mps2;
  spline.area_min_m = config.area_min_m;
  spline.area_max_m = config.area_max_m;
  for (const Eigen::Vector3d& perch_m : config.perches_m) {  // the box includes the perches
    spline.area_min_m = spline.area_min_m.cwiseMin(perch_m);
    spline.area_max_m = spline.area_max_m.cwiseMax(perch_m);
  }
  spline.leg_min_m = kLeg_m;
  spline.pace_min = config.speed_min_mps / config.speed_max_mps;
  spline.knot_s = kKnot_s;
  return spline;
}

}  // namespace

BirdFlight::BirdFlight(const BirdConfig& config, const Vector3& start_m, double vertical_speed_mps,
                       double vertical_acceleration_mps2)
    : config_(config),
      random_(config.seed, "guidance.bird"),
      spline_(spline_of(config), start_m, vertical_speed_mps, vertical_acceleration_mps2) {
  fly();
}

void BirdFlight::advance(double dt_s) {
  t_s_ += dt_s;
  spline_.advance(dt_s);
  if (phase_ == Phase::kFlying && t_s_ >= turn_at_s_) {
    spline_.roam();
    turn_at_s_ = t_s_ + drawn_s(config_.turn_s);
  }
  if (phase_ == Phase::kFlying && t_s_ >= change_at_s_ && !config_.perches_m.empty()) seek_perch();
  if (phase_ == Phase::kToPerch && (spline_.reference().position_m - perch_m_).norm() < kPerched_m) {
    phase_ = Phase::kPerched;
    change_at_s_ = t_s_ + drawn_s(kPerching_s);
  }
  if (phase_ == Phase::kPerched && t_s_ >= change_at_s_) {
    spline_.roam();
    fly();
  }
}

void BirdFlight::fly() {
  phase_ = Phase::kFlying;
  bounds_ = true;
  bounds_since_s_ = t_s_;
  turn_at_s_ = t_s_ + drawn_s(config_.turn_s);
  change_at_s_ = t_s_ + drawn_s(kFlying_s);
}

void BirdFlight::seek_perch() {
  phase_ = Phase::kToPerch;
  bounds_ = false;
  bounds_since_s_ = t_s_;
  const auto count = static_cast<double>(config_.perches_m.size());
  const auto drawn = static_cast<std::size_t>(count * random_.uniform(num_drawn_++, 0));
  perch_m_ = config_.perches_m[std::min(drawn, config_.perches_m.size() - 1)];
  spline_.rest_at(perch_m_, kLandingPace);
}

/// Uniform between 0.5 and 1.5 times the mean.
double BirdFlight::drawn_s(double mean_s) { return mean_s * random_.uniform(0.5, 1.5, num_drawn_++, 0); }

void BirdFlight::bounding_share(double (&share)[3]) const {
  const double u = std::clamp((t_s_ - bounds_since_s_) / kGrowing_s, 0.0, 1.0), w = 1.0 - u;
  const double grown = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u), sign = bounds_ ? 1.0 : -1.0;
  share[0] = bounds_ ? grown : 1.0 - grown;
  share[1] = sign * 30.0 * u * u * w * w / kGrowing_s;
  share[2] = sign * 60.0 * u * w * (w - u) / (kGrowing_s * kGrowing_s);
}

Reference BirdFlight::reference() const {
  Reference r = spline_.reference();
  const double rate_radps = 2.0 * kPi * kBounding_hz, angle_rad = rate_radps * t_s_;
  const double sine = elementary::sin(angle_rad), cosine = elementary::cos(angle_rad);
  double share[3];
  bounding_share(share);
  r.position_m.z() += kBounding_m * share[0] * sine;
  r.velocity_mps.z() += kBounding_m * (share[1] * sine + share[0] * rate_radps * cosine);
  r.acceleration_mps2.z() +=
      kBounding_m * ((share[2] - share[0] * rate_radps * rate_radps) * sine + 2.0 * share[1] * rate_radps * cosine);
  return r;
}

void BirdConfig::visit(ConfigVisitor& v) {
  v.field("seed", seed, "[-] random seed of the flight");
  v.field("speed_max_mps", speed_max_mps, "[m/s] largest speed, without the motion of bounding flight",
          Range::positive());
  v.field("speed_min_mps", speed_min_mps,
          "[m/s] smallest speed of a leg; the speed of a leg is drawn between this value and speed_max_mps",
          Range::positive());
  v.field("acceleration_max_mps2", acceleration_max_mps2, "[m/s^2] largest acceleration in turns", Range::positive());
  v.field("area_min_m", area_min_m,
          "[m] corner of smallest coordinates of the box around flight and start, world frame");
  v.field("area_max_m", area_max_m, "[m] corner of largest coordinates of that box, world frame");
  v.field("turn_s", turn_s, "[s] mean time between sudden turns; each time is 0.5 to 1.5 times the mean",
          Range::positive());
  v.field("perches_m", perches_m, "[m] positions of perches, world frame; none: the bird never perches");
  v.destinations("perches_m", perches_m);
  v.check((area_max_m.array() > area_min_m.array()).all(), "area_max_m", "more than area_min_m in each direction");
  v.check(speed_min_mps <= speed_max_mps && speed_min_mps >= 0.02 * speed_max_mps, "speed_min_mps",
          "from 0.02 of speed_max_mps to speed_max_mps");
}

std::unique_ptr<Guidance> make_bird(const ModuleConfig& config_in, const GuidanceSetup& setup) {
  const auto& config = dynamic_cast<const BirdConfig&>(config_in);
  expect_within("bird", setup.limits, "speed_max_mps", config.speed_max_mps, "acceleration_max_mps2",
                config.acceleration_max_mps2);
  return std::make_unique<EndlessFlight<BirdConfig, BirdFlight>>(config, setup);
}

}  // namespace swiftlet
