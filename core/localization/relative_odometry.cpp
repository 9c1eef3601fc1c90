// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/relative_odometry.hpp"

#include <cmath>
#include <numbers>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

double squared(double x) { return x * x; }

/// Cubic Hermite interpolation of position and velocity between the samples `a` and `b`, which are `dt_s` apart.
/// @param s  share of the interval that has elapsed, 0 to 1
void interpolate_cubic(const OtherMotion& a, const OtherMotion& b, double s, double dt_s, OtherMotion& out) {
  const Vector3 step_m = b.p_other_local_m - a.p_other_local_m;
  const Vector3 out_m = dt_s * a.v_other_local_mps, in_m = dt_s * b.v_other_local_mps;
  // p = a + out s + quadratic s^2 + cubic s^3
  const Vector3 quadratic_m = 3.0 * step_m - 2.0 * out_m - in_m, cubic_m = out_m + in_m - 2.0 * step_m;
  out.p_other_local_m = a.p_other_local_m + s * (out_m + s * (quadratic_m + s * cubic_m));
  out.v_other_local_mps = (out_m + s * (2.0 * quadratic_m + 3.0 * s * cubic_m)) / dt_s;
}

}  // namespace

void OdometryDriftConfig::visit(ConfigVisitor& v) {
  v.field("position_m_psqrtm", position_m_psqrtm,
          "[m/sqrt(m)] random walk of the position: standard deviation per axis after 1 m of path",
          Range::between(0.0, 10.0));
  v.field("yaw_deg_psqrtm", yaw_deg_psqrtm,
          "[deg/sqrt(m)] random walk of the heading: standard deviation after 1 m of path", Range::between(0.0, 90.0));
}

// Drift rates are configured per root of a turn and used per radian.
OdometryDrift::OdometryDrift(const OdometryDriftConfig& config)
    : position_{squared(config.position_m_psqrtm), squared(config.position_m_psqrtturn) / (2.0 * kPi),
                squared(config.position_m_psqrts)},
      yaw_{squared(config.yaw_deg_psqrtm * kRadPerDeg), squared(config.yaw_deg_psqrtturn * kRadPerDeg) / (2.0 * kPi),
           squared(config.yaw_deg_psqrts * kRadPerDeg)} {}

bool RelativeOdometry::push(OtherMotion sample) {
  if (!sample.p_other_local_m.allFinite() || !sample.v_other_local_mps.allFinite()) return false;
  if (!std::isfinite(sample.yaw_rad) || !std::isfinite(sample.yaw_rate_radps)) return false;
  sample.flown = {};
  if (count_ > 0) {
    const OtherMotion& last = newest();
    if (sample.t <= last.t) return false;
    sample.flown.path_m = last.flown.path_m + (sample.p_other_local_m - last.p_other_local_m).norm();
    sample.flown.turn_rad = last.flown.turn_rad + std::abs(std::remainder(sample.yaw_rad - last.yaw_rad, 2.0 * kPi));
    sample.flown.time_s = last.flown.time_s + to_seconds(sample.t - last.t);
  }
  if (count_ < kCapacity)
    ++count_;
  else
    first_ = (first_ + 1) % kCapacity;
  ring_[(first_ + count_ - 1) % kCapacity] = sample;
  return true;
}

std::optional<OtherMotion> RelativeOdometry::at(TimeNs t, double gap_max_s) const {
  if (count_ == 0 || t < (*this)[0].t || t > newest().t) return std::nullopt;
  int after = count_ - 1;
  while (after > 0 && (*this)[after - 1].t >= t) --after;
  const OtherMotion& b = (*this)[after];
  if (t == b.t) return b;
  const OtherMotion& a = (*this)[after - 1];
  const double dt_s = to_seconds(b.t - a.t);
  if (dt_s > gap_max_s) return std::nullopt;
  const double s = to_seconds(t - a.t) / dt_s;
  OtherMotion out;
  out.t = t;
  interpolate_cubic(a, b, s, dt_s, out);
  out.yaw_rad = a.yaw_rad + s * std::remainder(b.yaw_rad - a.yaw_rad, 2.0 * kPi);
  out.yaw_rate_radps = a.yaw_rate_radps + s * (b.yaw_rate_radps - a.yaw_rate_radps);
  out.flown.path_m = a.flown.path_m + s * (b.flown.path_m - a.flown.path_m);
  out.flown.turn_rad = a.flown.turn_rad + s * (b.flown.turn_rad - a.flown.turn_rad);
  out.flown.time_s = a.flown.time_s + s * (b.flown.time_s - a.flown.time_s);
  return out;
}

}  // namespace swiftlet
