// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/airframe.hpp"

namespace swiftlet {

/// What the rotors together do to the body: thrust along +z [N] and torque in body axes [N m].
struct Wrench {
  double thrust_N = 0.0;
  Vector3 torque_body_Nm = Vector3::Zero();
};

/// From a wrench to the thrust of each rotor and back, for up to kMaxRotors rotors whose axes are parallel to body z.
class Mixer {
 public:
  using Forces = std::array<double, kMaxRotors>;

  /// Throws std::invalid_argument when the rotors cannot make thrust and all three torques independently.
  explicit Mixer(const Airframe& airframe);

  int num_rotors() const { return num_rotors_; }
  /// What the rotors' thrusts add up to (effectiveness B of the airframe).
  Wrench wrench(const Forces& force_N) const;
  /// Least-norm thrusts (pseudo-inverse of B) for the wrench, each between what the rotor can do. When the wrench is
  /// out of reach, yaw torque is given up first, then the thrust is moved, then roll and pitch shrink together.
  /// @param lift_N  roll and pitch may raise a lower thrust to this and no further. Where a controller asks for
  ///     too much torque again and again, half of all thrust would carry the vehicle away.
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
