// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/inertial_model.hpp"

#include <cmath>

#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/localization/rotation.hpp"

namespace swiftlet {

Vector3 InertialModel::State::gravity_local_mps2() const {
  return kGravity_mps2 * Vector3(tilt_local.x(), tilt_local.y(), -std::sqrt(1.0 - tilt_local.squaredNorm()));
}

InertialModel::State InertialModel::State::changed_by(const Error& d) const {
  State out = *this;
  out.nav.p_m += d.segment<3>(kP);
  out.nav.v_mps += d.segment<3>(kV);
  out.nav.q = (nav.q * rotation_by(d.segment<3>(kTheta))).normalized();
  out.nav.omega_body_radps -= d.segment<3>(kGyroBias);
  out.accel_bias_body_mps2 += d.segment<3>(kAccelBias);
  out.gyro_bias_body_radps += d.segment<3>(kGyroBias);
  out.tilt_local += d.segment<2>(kTilt);
  out.time_offset_s += d(kTimeOffset);
  if (out.tilt_local.squaredNorm() > 0.9) out.tilt_local *= std::sqrt(0.9) / out.tilt_local.norm();
  return out;
}

InertialModel::State InertialModel::advanced(const State& state, const Vector3& omega_body_radps,
                                             const Vector3& force_body_mps2, double dt_s) {
  State out = state;
  const Eigen::Quaterniond half = rotation_by(0.5 * dt_s * omega_body_radps);
  const Eigen::Quaterniond q_middle = state.nav.q * half;
  const Vector3 a = q_middle * force_body_mps2 + state.gravity_local_mps2();
  out.nav.p_m += dt_s * (state.nav.v_mps + 0.5 * dt_s * a);
  out.nav.v_mps += dt_s * a;
  out.nav.q = (q_middle * half).normalized();
  out.nav.omega_body_radps = omega_body_radps;
  return out;
}

/// Sola, eqs. 270 and 271: first order in dt, second where position depends on acceleration.
InertialModel::Covariance InertialModel::transition(const State& state, const Vector3& omega_body_radps,
                                                    const Vector3& force_body_mps2, double dt_s) {
  const Matrix3 R = (state.nav.q * rotation_by(0.5 * dt_s * omega_body_radps)).toRotationMatrix();
  const Matrix3 a_by_theta = -R * skew_of(force_body_mps2);
  Eigen::Matrix<double, 3, 2> a_by_tilt = Eigen::Matrix<double, 3, 2>::Zero();
  a_by_tilt.topRows<2>().diagonal().setConstant(kGravity_mps2);
  a_by_tilt.row(2) = kGravity_mps2 / std::sqrt(1.0 - state.tilt_local.squaredNorm()) * state.tilt_local.transpose();
  Covariance F = Covariance::Identity();
  F.block<3, 3>(kP, kV) = Matrix3::Identity() * dt_s;
  F.block<3, 3>(kP, kTheta) = 0.5 * dt_s * dt_s * a_by_theta;
  F.block<3, 3>(kP, kAccelBias) = -0.5 * dt_s * dt_s * R;
  F.block<3, 2>(kP, kTilt) = 0.5 * dt_s * dt_s * a_by_tilt;
  F.block<3, 3>(kV, kTheta) = dt_s * a_by_theta;
  F.block<3, 3>(kV, kAccelBias) = -dt_s * R;
  F.block<3, 2>(kV, kTilt) = dt_s * a_by_tilt;
  F.block<3, 3>(kTheta, kTheta) = rotation_by(-dt_s * omega_body_radps).toRotationMatrix();
  F.block<3, 3>(kTheta, kGyroBias) = -dt_s * Matrix3::Identity();
  return F;
}

}  // namespace swiftlet
