// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"

/// Noise models of the sensors. Every number is a function of (seed, purpose, entity, sample, axis).
namespace swiftlet::sim {

/// Three independent standard normals for sample `index`.
inline Vector3 normal3(const Random& random, std::uint32_t index) {
  const auto n = random.normal3(index, 0);
  return {n[0], n[1], n[2]};
}

/// First-order Gauss-Markov process in three axes, dx = -x/tau dt + sigma_walk dW, in its exact discrete form (for any
/// step length). tau = 0 gives an unlimited random walk. Any frame, the same for all arguments.
class GaussMarkov {
 public:
  /// Starts at zero. @param walk_density  sigma_walk [unit/sqrt(s)]  @param time_s  tau
  static GaussMarkov walking(const Vector3& walk_density, double time_s) { return {walk_density, time_s}; }
  /// Stationary from its first sample on, with standard deviation `sigma`; time_s > 0.
  static GaussMarkov stationary(const Vector3& sigma, double time_s, const Vector3& first_normals) {
    GaussMarkov process(sigma * std::sqrt(2.0 / time_s), time_s);
    process.value_ = sigma.cwiseProduct(first_normals);
    return process;
  }
  GaussMarkov() = default;

  void advance(double dt_s, const Vector3& normals) {
    if (time_s_ <= 0.0) {
      value_ += walk_density_.cwiseProduct(normals) * std::sqrt(dt_s);
      return;
    }
    if (dt_s != dt_s_) {  // recomputed only for a changed step
      dt_s_ = dt_s;
      decay_ = elementary::exp(-dt_s / time_s_);
      spread_ = std::sqrt(0.5 * time_s_ * (1.0 - decay_ * decay_));
    }
    value_ = decay_ * value_ + walk_density_.cwiseProduct(normals) * spread_;
  }
  const Vector3& value() const { return value_; }

 private:
  GaussMarkov(const Vector3& walk_density, double time_s) : walk_density_(walk_density), time_s_(time_s) {}

  Vector3 walk_density_ = Vector3::Zero();
  double time_s_ = 0.0;
  Vector3 value_ = Vector3::Zero();
  double dt_s_ = 0.0;  ///< step for which the two values below hold
  double decay_ = 1.0, spread_ = 0.0;
};

/// R = Rz(yaw) Ry(pitch) Rx(roll).
inline Eigen::Quaterniond rotation_of_rpy(const Vector3& rpy_rad) {
  return Eigen::AngleAxisd(rpy_rad.z(), Vector3::UnitZ()) * Eigen::AngleAxisd(rpy_rad.y(), Vector3::UnitY()) *
         Eigen::AngleAxisd(rpy_rad.x(), Vector3::UnitX());
}

/// Rotation by the rotation vector. Any frame, the same for all arguments.
inline Eigen::Quaterniond rotation_exp(const Vector3& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (angle < 1e-12) {
    return Eigen::Quaterniond(1.0, 0.5 * rotation_vector.x(), 0.5 * rotation_vector.y(), 0.5 * rotation_vector.z())
        .normalized();
  }
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, rotation_vector / angle));
}

/// Rotation vector of the shorter rotation.
inline Vector3 rotation_log(Eigen::Quaterniond q) {
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < 1e-12) return 2.0 * q.vec();
  return q.vec() * (2.0 * elementary::atan2(sine, q.w()) / sine);
}

/// Wraps to (-pi, pi].
inline double wrap_angle(double angle_rad) {
  const double wrapped = std::remainder(angle_rad, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

}  // namespace swiftlet::sim
