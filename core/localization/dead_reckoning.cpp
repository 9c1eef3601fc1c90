// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/dead_reckoning.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/gravity.hpp"

namespace swiftlet {

Eigen::Quaterniond rotation_by(const Vector3& angle_rad) {
  const double angle_sq = angle_rad.squaredNorm();
  if (angle_sq < 1e-8) {  // series to third order: exact to the last bits here
    return Eigen::Quaterniond(1.0 - angle_sq / 8.0, 0.5 * angle_rad.x(), 0.5 * angle_rad.y(), 0.5 * angle_rad.z())
        .normalized();
  }
  const double angle = std::sqrt(angle_sq);
  const Vector3 axis = angle_rad * (elementary::sin(0.5 * angle) / angle);
  return {elementary::cos(0.5 * angle), axis.x(), axis.y(), axis.z()};
}

void strapdown(NavState& state, const Vector3& omega_body_radps, const Vector3& specific_force_body_mps2, double dt_s) {
  const Eigen::Quaterniond q_middle = state.q * rotation_by(0.5 * dt_s * omega_body_radps);
  const Vector3 a = q_middle * specific_force_body_mps2 - kGravity_mps2 * Vector3::UnitZ();
  state.p_m += dt_s * (state.v_mps + 0.5 * dt_s * a);
  state.v_mps += dt_s * a;
  state.q = (q_middle * rotation_by(0.5 * dt_s * omega_body_radps)).normalized();
  state.omega_body_radps = omega_body_radps;
}

void DeadReckoning::push(const ImuSample& sample) {
  if (take(sample)) apply(sample);
}

void DeadReckoning::keep(const ImuSample& sample) { take(sample); }

bool DeadReckoning::take(const ImuSample& sample) {
  if (!sample.omega_body_radps.allFinite() || !sample.specific_force_body_mps2.allFinite()) return false;
  if (count_ > 0 && sample.t <= ring_[newest_].t) return false;
  newest_ = (newest_ + 1) % kCapacity;
  count_ = std::min(count_ + 1, kCapacity);
  ring_[newest_] = sample;
  return true;
}

void DeadReckoning::restart(const NavState& state) {
  state_ = state;
  int age = 0;
  while (age < count_ && sample(age).t > state.t) ++age;
  while (age > 0) apply(sample(--age));
}

void DeadReckoning::apply(const ImuSample& s) {
  if (s.t <= state_.t) return;
  strapdown(state_, s.omega_body_radps, s.specific_force_body_mps2, to_seconds(s.t - state_.t));
  state_.t = s.t;
}

NavState DeadReckoning::at(TimeNs t) const {
  NavState out = state_;
  if (count_ > 0) out.omega_body_radps = ring_[newest_].omega_body_radps;
  if (t <= state_.t) return out;
  const double dt_s = to_seconds(t - state_.t);
  if (count_ > 0) {
    strapdown(out, ring_[newest_].omega_body_radps, ring_[newest_].specific_force_body_mps2, dt_s);
  } else {
    out.p_m += dt_s * out.v_mps;
    out.q = (out.q * rotation_by(dt_s * out.omega_body_radps)).normalized();
  }
  out.t = t;
  return out;
}

}  // namespace swiftlet
