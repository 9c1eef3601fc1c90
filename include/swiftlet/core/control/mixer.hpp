// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/base/airframe.hpp"

namespace swiftlet {

/// Total thrust along +z [N] and torque in body axes [N m] of all rotors.
struct Wrench {
  double thrust_N = 0.0;
  Vector3 torque_body_Nm = Vector3::Zero();
};

/// Maps a wrench to the thrust of each rotor and back, for up to kMaxRotors rotors whose axes are parallel to body z.
class Mixer {
 public:
  using Forces = std::array<double, kMaxRotors>;

  /// Throws std::invalid_argument when the rotors cannot produce thrust and all three torques independently.
  explicit Mixer(const Airframe& airframe);

  int num_rotors() const { return num_rotors_; }
  /// Wrench of the given rotor thrusts (effectiveness B of the airframe).
  Wrench wrench(const Forces& force_N) const;
  /// Least-norm thrusts (pseudo-inverse of B) for the wrench, each within the limits of a rotor. When the wrench is out
  /// of reach, yaw torque is reduced first, then the thrust is changed, then roll and pitch torque are scaled down
  /// together.
  /// @param lift_N  roll and pitch torque may raise a lower thrust up to this value. A controller that demands too much
  /// torque repeatedly would otherwise make the vehicle climb with half of the maximum thrust.
  Forces forces(const Wrench& wanted, double lift_N = std::numeric_limits<double>::infinity()) const;

  double min_force_N() const { return min_force_N_; }
  double max_force_N() const { return max_force_N_; }

 private:
  int num_rotors_ = 0;
  double min_force_N_ = 0.0;
  double max_force_N_ = 0.0;
  Eigen::Matrix<double, 4, kMaxRotors> effectiveness_ = Eigen::Matrix<double, 4, kMaxRotors>::Zero();
  Eigen::Matrix<double, kMaxRotors, 4> inverse_ = Eigen::Matrix<double, kMaxRotors, 4>::Zero();
};

}  // namespace swiftlet
