// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/agile.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/guidance/flight/endless_flight.hpp"
#include "core/guidance/guidance_constants.hpp"
#include "swiftlet/core/guidance/within_limits.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [m] distance from a target at which the next one is chosen. Larger values cut corners.
constexpr double kTargetReached_m = 4.0;
/// [-] speed at a target, as a share of the greatest speed. Larger values make wider turns.
constexpr double kPassingShare = 0.5;

bool is_inside(const Vector3& p, const Vector3& min, const Vector3& max) {
  return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
}

/// Limits a step to the length `longest`, and to `longest_z` along the vertical.
Vector3 cut_to(Vector3 v, double longest, double longest_z) {
  v.z() = std::clamp(v.z(), -longest_z, longest_z);
  const double length = v.norm();
  return length > longest ? Vector3(v * (longest / length)) : v;
}

}  // namespace

AgileSpline::AgileSpline(const AgileConfig& config, const Vector3& start_m, double vertical_speed_mps,
                         double vertical_acceleration_mps2)
    : config_(config),
      random_(config.seed, "guidance.agile"),
      step_max_m_(config.speed_max_mps * config.knot_s),
      step_max_z_m_(std::min(config.speed_max_mps, vertical_speed_mps) * config.knot_s),
      change_max_m_(config.acceleration_max_mps2 * config.knot_s * config.knot_s),
      change_max_z_m_(std::min(config.acceleration_max_mps2, vertical_acceleration_mps2) * config.knot_s *
                      config.knot_s),
      box_min_m_(config.area_min_m.cwiseMin(start_m)),
      box_max_m_(config.area_max_m.cwiseMax(start_m)) {
  control_m_.fill(start_m);
  pick_target(start_m);
}

void AgileSpline::advance(double dt_s) {
  u_ += dt_s / config_.knot_s;
  while (u_ >= 1.0) {
    u_ -= 1.0;
    add_control_point();
  }
}

void AgileSpline::rest_at(const Vector3& point_m, double pace) {
  target_m_ = point_m;
  pace_ = pace;
  rests_ = true;
}

void AgileSpline::roam() {
  rests_ = false;
  pick_target(control_m_[4]);
}

Reference AgileSpline::reference() const {
  // Uniform quartic B-spline basis on its five control points; derivatives from their differences.
  const double u = u_, u2 = u * u, u3 = u2 * u, u4 = u2 * u2, w = 1.0 - u;
  const auto& c = control_m_;
  Reference r;
  r.position_m = (w * w * w * w * c[0] + (11.0 - 12.0 * u - 6.0 * u2 + 12.0 * u3 - 4.0 * u4) * c[1] +
                  (11.0 + 12.0 * u - 6.0 * u2 - 12.0 * u3 + 6.0 * u4) * c[2] +
                  (1.0 + 4.0 * u + 6.0 * u2 + 4.0 * u3 - 4.0 * u4) * c[3] + u4 * c[4]) /
                 24.0;
  r.velocity_mps = (w * w * w * (c[1] - c[0]) + (4.0 - 6.0 * u2 + 3.0 * u3) * (c[2] - c[1]) +
                    (1.0 + 3.0 * u + 3.0 * u2 - 3.0 * u3) * (c[3] - c[2]) + u3 * (c[4] - c[3])) /
                   (6.0 * config_.knot_s);
  r.acceleration_mps2 = (w * w * (c[2] - 2.0 * c[1] + c[0]) + (1.0 + 2.0 * u - 2.0 * u2) * (c[3] - 2.0 * c[2] + c[1]) +
                         u2 * (c[4] - 2.0 * c[3] + c[2])) /
                        (2.0 * config_.knot_s * config_.knot_s);
  return r;
}

Vector3 AgileSpline::jerk_mps3() const {
  const auto& c = control_m_;
  const Vector3 third_0 = c[3] - 3.0 * c[2] + 3.0 * c[1] - c[0];
  const Vector3 third_1 = c[4] - 3.0 * c[3] + 3.0 * c[2] - c[1];
  return ((1.0 - u_) * third_0 + u_ * third_1) / (config_.knot_s * config_.knot_s * config_.knot_s);
}

void AgileSpline::add_control_point() {
  const Vector3 point = control_m_[4];
  const Vector3 step = control_m_[4] - control_m_[3];
  if (!rests_ && (point - target_m_).norm() < kTargetReached_m) pick_target(point);

  // The step nearest to the wanted one that leaves room to stop inside the box. Full braking always does.
  const Vector3 wanted = step + cut_to(desired_step(point) - step, pace_ * change_max_m_, pace_ * change_max_z_m_);
  const Vector3 braked = brake(step);
  double good = 0.0, bad = 1.0;
  const auto blend = [&](double share) { return Vector3(braked + share * (wanted - braked)); };
  if (can_stop_inside(point + wanted, wanted)) good = 1.0;
  for (int i = 0; i < 16 && good < 1.0; ++i) {
    const double middle = 0.5 * (good + bad);
    (can_stop_inside(point + blend(middle), blend(middle)) ? good : bad) = middle;
  }
  std::rotate(control_m_.begin(), control_m_.begin() + 1, control_m_.end());
  control_m_[4] = point + blend(good);
}

/// Draws a point of the area at least leg_min_m away (the last draw if the area is too small), and the leg's factor
/// on speed and acceleration.
void AgileSpline::pick_target(const Vector3& from_m) {
  for (int attempt = 0; attempt < 32; ++attempt) {
    const std::uint32_t n = num_targets_++;
    for (int i = 0; i < 3; ++i) {
      target_m_[i] = random_.uniform(config_.area_min_m[i], config_.area_max_m[i], n, static_cast<std::uint32_t>(i));
    }
    if ((target_m_ - from_m).norm() >= config_.leg_min_m) break;
  }
  pace_ = random_.uniform(config_.pace_min, 1.0, num_targets_ - 1, 3);
}

Vector3 AgileSpline::desired_step(const Vector3& point) const {
  const Vector3 to_target = target_m_ - point;
  const double distance = to_target.norm();
  if (distance < kNegligible) return Vector3::Zero();
  const double longest = pace_ * step_max_m_, passing = rests_ ? 0.0 : kPassingShare * longest;
  double length = std::min(longest, std::sqrt(passing * passing + 1.6 * pace_ * change_max_m_ * distance));
  if (rests_) length = std::min(length, distance);
  return cut_step(to_target * (length / distance));
}

Vector3 AgileSpline::cut_step(const Vector3& step) const { return cut_to(step, step_max_m_, step_max_z_m_); }

/// Largest reduction of the step's length within one knot, at constant direction.
double AgileSpline::braking_per_knot(const Vector3& step) const {
  const double length = step.norm();
  const double z_share = length > 0.0 ? std::abs(step.z()) / length : 0.0;
  return z_share * change_max_m_ > change_max_z_m_ ? change_max_z_m_ / z_share : change_max_m_;
}

Vector3 AgileSpline::brake(const Vector3& step) const {
  const double length = step.norm();
  const double braking = braking_per_knot(step);
  return length <= braking ? Vector3::Zero() : Vector3(step * ((length - braking) / length));
}

bool AgileSpline::can_stop_inside(const Vector3& point, const Vector3& step) const {
  const double length = step.norm();
  const double braking = braking_per_knot(step);
  const double n = std::floor(length / braking);
  const double stopping_distance = n * length - 0.5 * braking * n * (n + 1.0);  // (length - b) + (length - 2 b) + ...
  const Vector3 stop = length > 0.0 ? Vector3(point + step * (stopping_distance / length)) : point;
  return is_inside(point, box_min_m_, box_max_m_) && is_inside(stop, box_min_m_, box_max_m_);
}

void AgileConfig::visit(ConfigVisitor& v) {
  v.field("seed", seed, "[-] random seed of the trajectory");
  v.field("speed_max_mps", speed_max_mps, "[m/s] upper bound of the speed", Range::positive());
  v.field("acceleration_max_mps2", acceleration_max_mps2, "[m/s^2] upper bound of the acceleration", Range::positive());
  v.field("area_min_m", area_min_m,
          "[m] corner of smallest coordinates of the box around trajectory and start, world frame");
  v.field("area_max_m", area_max_m, "[m] corner of largest coordinates of that box, world frame");
  v.field("pace_min", pace_min,
          "[-] smallest factor on the largest speed and acceleration; the factor of a leg is drawn between this value "
          "and 1",
          Range::between(0.02, 1.0));
  v.choice("yaw", yaw, {"along_path", "fixed"}, "[-] heading: along the velocity, or yaw_deg");
  v.field("yaw_deg", yaw_deg, "[deg] heading, if the choice is fixed");
  v.check((area_max_m.array() > area_min_m.array()).all(), "area_max_m", "more than area_min_m in each direction");
}

std::unique_ptr<Guidance> make_agile(const ModuleConfig& config_in, const GuidanceSetup& setup) {
  const auto& config = dynamic_cast<const AgileConfig&>(config_in);
  expect_within("agile", setup.limits, "speed_max_mps", config.speed_max_mps, "acceleration_max_mps2",
                config.acceleration_max_mps2);
  std::optional<double> yaw_world_rad;
  if (config.yaw == AgileConfig::Yaw::kFixed) yaw_world_rad = radians(config.yaw_deg);
  return std::make_unique<EndlessFlight<AgileConfig, AgileSpline>>(config, setup, yaw_world_rad);
}

}  // namespace swiftlet
