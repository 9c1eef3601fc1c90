// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/control/mixer.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace swiftlet {
namespace {

using Column = Eigen::Matrix<double, kMaxRotors, 1>;

/// [-] Share of a rotor in the thrust below which it is a rounding error: the rotor only makes torque. Larger values
/// ignore the limits of rotors that lift little.
constexpr double kNoShare = 1e-9;

/// Largest factor in [0, 1] by which `part` can be added to `base` while every rotor stays in [min, max].
double largest_factor(const Column& base, const Column& part, int n, double min, double max) {
  double share = 1.0;
  for (int i = 0; i < n; ++i) {
    if (part[i] > 0.0) share = std::min(share, (max - base[i]) / part[i]);
    if (part[i] < 0.0) share = std::min(share, (min - base[i]) / part[i]);
  }
  return std::max(share, 0.0);
}

}  // namespace

Mixer::Mixer(const Airframe& airframe) : num_rotors_(airframe.num_rotors()) {
  if (num_rotors_ > kMaxRotors) throw std::invalid_argument("airframe: expected at most 8 rotors");
  const auto force_at = [&](double speed) { return airframe.thrust_constant_N_per_radps2 * speed * speed; };
  min_force_N_ = force_at(airframe.rotor_speed_min_radps);
  max_force_N_ = force_at(airframe.rotor_speed_max_radps);

  // Columns are the wrench per thrust of a rotor. Its drag torque on the body is opposite to its sense of rotation.
  for (int i = 0; i < num_rotors_; ++i) {
    const Rotor& rotor = airframe.rotors[i];
    effectiveness_.col(i) << 1.0, rotor.position_m.y(), -rotor.position_m.x(),
        -rotor.direction() * airframe.torque_to_thrust_m;
  }

  // Torque rows are divided by their lever arms, so that the rank test does not depend on the size of the vehicle.
  const Eigen::Vector4d scale(1.0, 1.0 / airframe.arm_length_m, 1.0 / airframe.arm_length_m,
                              1.0 / airframe.torque_to_thrust_m);
  const Eigen::Matrix<double, 4, kMaxRotors> scaled = scale.asDiagonal() * effectiveness_;
  const Eigen::LDLT<Eigen::Matrix4d> gram(scaled * scaled.transpose());
  const bool full_rank = gram.vectorD().minCoeff() > 1e-12 * gram.vectorD().maxCoeff();
  if (num_rotors_ < 4 || !full_rank) {
    throw std::invalid_argument("airframe: expected rotors that make thrust and torque about all three axes, found " +
                                std::to_string(num_rotors_) + " rotors that do not");
  }
  // Pseudo-inverse A^T (A A^T)^-1 of the effectiveness A, whose rows are independent.
  inverse_ = scaled.transpose() * gram.solve(Eigen::Matrix4d(scale.asDiagonal()));
}

Wrench Mixer::wrench(const Forces& force_N) const {
  const Eigen::Vector4d w = effectiveness_ * Eigen::Map<const Column>(force_N.data());
  return {w[0], w.tail<3>()};
}

Mixer::Forces Mixer::forces(const Wrench& wanted, double lift_N) const {
  const int n = num_rotors_;
  // Rotor forces of the roll and pitch torque.
  Column tilt = inverse_.col(1) * wanted.torque_body_Nm.x() + inverse_.col(2) * wanted.torque_body_Nm.y();

  // Both torques are scaled down by one factor, which keeps their direction, until the differences between rotors fit
  // into the range of a rotor, and no rotor is below its minimum at the larger of the demanded thrust and lift_N.
  const double span = max_force_N_ - min_force_N_;
  const double tilt_span = tilt.head(n).maxCoeff() - tilt.head(n).minCoeff();
  double scale = tilt_span > span ? span / tilt_span : 1.0;
  const double lifted_N = std::max(wanted.thrust_N, lift_N);
  for (int i = 0; i < n; ++i) {
    const double room_N = std::max(lifted_N * inverse_(i, 0) - min_force_N_, 0.0);
    if (tilt[i] < 0.0 && inverse_(i, 0) > kNoShare) scale = std::min(scale, -room_N / tilt[i]);
  }
  tilt *= scale;

  // The thrust is limited to the range in which every rotor keeps its limits together with roll and pitch. Column 0 of
  // the inverse is the share of each rotor in the thrust.
  double least = 0.0, greatest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < n; ++i) {
    const double share = inverse_(i, 0);
    if (share <= kNoShare) continue;
    least = std::max(least, (min_force_N_ - tilt[i]) / share);
    greatest = std::min(greatest, (max_force_N_ - tilt[i]) / share);
  }
  const double thrust = least <= greatest ? std::clamp(wanted.thrust_N, least, greatest) : 0.5 * (least + greatest);
  const Column base = inverse_.col(0) * thrust + tilt;

  // The yaw torque is scaled down to the remaining range of the rotors.
  const Column yaw = inverse_.col(3) * wanted.torque_body_Nm.z();
  const Column total = base + largest_factor(base, yaw, n, min_force_N_, max_force_N_) * yaw;
  Forces out{};
  for (int i = 0; i < n; ++i) out[i] = std::clamp(total[i], min_force_N_, max_force_N_);
  return out;
}

}  // namespace swiftlet
