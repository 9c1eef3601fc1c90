// SPDX-License-Identifier: BSD-3-Clause
// Free flight against the model of ctu-mrs/mrs_multirotor_simulator (d0d31e6) in its own formulation: revolutions per
// minute, an allocation matrix, a rotation matrix as state, drag in newton.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/sim/physics/flight.hpp"

namespace swiftlet::sim {
namespace {

// The X500 of its config/uavs/x500.yaml.
constexpr double kMass_kg = 2.0, kArm_m = 0.25, kBodyHeight_m = 0.1, kPropeller_m = 0.15;
constexpr double kThrust_N_per_rpm2 = 2.7087e-7, kTorque = 0.07;
constexpr double kLeast_rpm = 1170.0, kMost_rpm = 7800.0, kMotorTime_s = 0.03, kAirResistance = 0.30;
constexpr double kRadps_per_rpm = 2.0 * std::numbers::pi / 60.0;

struct MrsModel {
  Vector3 p_m = Vector3::Zero(), v_mps = Vector3::Zero();
  Matrix3 R = Matrix3::Identity();
  Vector3 omega_radps = Vector3::Zero();
  Eigen::Vector4d rpm = Eigen::Vector4d::Zero();

  MrsModel plus(const MrsModel& slope, double h) const {
    return {p_m + h * slope.p_m, v_mps + h * slope.v_mps, R + h * slope.R, omega_radps + h * slope.omega_radps,
            rpm + h * slope.rpm};
  }

  MrsModel slope(const Eigen::Vector4d& command) const {
    // Rotors in their order: front right, rear left (both counterclockwise), front left, rear right.
    const double arm = kThrust_N_per_rpm2 * kArm_m / std::numbers::sqrt2;
    const double yaw = kTorque * 3.0 * kPropeller_m * kThrust_N_per_rpm2;
    Eigen::Matrix4d allocation;
    allocation << -arm, arm, arm, -arm,  //
        -arm, arm, -arm, arm,            //
        -yaw, -yaw, yaw, yaw,            //
        kThrust_N_per_rpm2, kThrust_N_per_rpm2, kThrust_N_per_rpm2, kThrust_N_per_rpm2;
    const Eigen::Vector4d load = allocation * rpm.cwiseAbs2();
    const double J_xy = kMass_kg * (3.0 * kArm_m * kArm_m + kBodyHeight_m * kBodyHeight_m) / 12.0;
    const Matrix3 J = Vector3(J_xy, J_xy, kMass_kg * kArm_m * kArm_m / 2.0).asDiagonal();
    const double drag_N = kAirResistance * std::numbers::pi * kArm_m * kArm_m * v_mps.squaredNorm();
    Matrix3 skew;
    skew << 0, -omega_radps.z(), omega_radps.y(), omega_radps.z(), 0, -omega_radps.x(), -omega_radps.y(),
        omega_radps.x(), 0;
    MrsModel d;
    d.p_m = v_mps;
    d.v_mps = Vector3(0, 0, -kGravity) + R.col(2) * load[3] / kMass_kg;
    if (v_mps.norm() > 0.0) d.v_mps -= drag_N / kMass_kg * v_mps.normalized();
    d.R = R * skew;
    d.omega_radps = J.inverse() * (load.head<3>() - omega_radps.cross(J * omega_radps));
    d.rpm = ((kLeast_rpm + (kMost_rpm - kLeast_rpm) * command.array()).matrix() - rpm) / kMotorTime_s;
    return d;
  }

  void step(const Eigen::Vector4d& command, double h) {
    const MrsModel k1 = slope(command), k2 = plus(k1, 0.5 * h).slope(command), k3 = plus(k2, 0.5 * h).slope(command),
                   k4 = plus(k3, h).slope(command);
    *this = plus(k1, h / 6.0).plus(k2, h / 3.0).plus(k3, h / 3.0).plus(k4, h / 6.0);
    // Gram-Schmidt, as orthogonality drifts.
    R.col(0).normalize();
    R.col(1) = (R.col(1) - R.col(0).dot(R.col(1)) * R.col(0)).normalized();
    R.col(2) = R.col(0).cross(R.col(1));
  }
};

Airframe x500_of_that_model() {
  Airframe airframe = test_quad();
  const double side_m = kArm_m / std::numbers::sqrt2;
  const double height_m = 0.05;
  airframe.rotors = {{{side_m, -side_m, height_m}, Rotor::Spin::kCcw},
                     {{-side_m, side_m, height_m}, Rotor::Spin::kCcw},
                     {{side_m, side_m, height_m}, Rotor::Spin::kCw},
                     {{-side_m, -side_m, height_m}, Rotor::Spin::kCw}};
  airframe.mass_kg = kMass_kg;
  const double J_xy = kMass_kg * (3.0 * kArm_m * kArm_m + kBodyHeight_m * kBodyHeight_m) / 12.0;
  airframe.inertia_diagonal_kgm2 = {J_xy, J_xy, kMass_kg * kArm_m * kArm_m / 2.0};
  airframe.thrust_constant_N_per_radps2 = kThrust_N_per_rpm2 / (kRadps_per_rpm * kRadps_per_rpm);
  airframe.torque_to_thrust_m = kTorque * 3.0 * kPropeller_m;
  airframe.motor_time_constant_up_s = airframe.motor_time_constant_down_s = kMotorTime_s;
  airframe.rotor_speed_min_radps = kLeast_rpm * kRadps_per_rpm;
  airframe.rotor_speed_max_radps = kMost_rpm * kRadps_per_rpm;
  airframe.rotor_inertia_kgm2 = 0.0;
  airframe.rotor_drag_N_per_radps_mps = 0.0;
  airframe.body_drag_area_m2.setConstant(2.0 * kAirResistance * std::numbers::pi * kArm_m * kArm_m / 1.225);
  return airframe;
}

// Rolls, pitches and yaws to and fro, so that the vehicle tumbles and the rates stay those of a vehicle.
Eigen::Vector4d command_at(int half_second) {
  constexpr double kTurn = 0.02;
  const double turn = half_second % 4 < 2 ? kTurn : -kTurn;
  if (half_second % 3 == 0) return Eigen::Vector4d(0.6 - turn, 0.6 + turn, 0.6 + turn, 0.6 - turn);
  if (half_second % 3 == 1) return Eigen::Vector4d(0.6 - turn, 0.6 + turn, 0.6 - turn, 0.6 + turn);
  return Eigen::Vector4d(0.6 + 2 * turn, 0.6 + 2 * turn, 0.6 - 2 * turn, 0.6 - 2 * turn);
}

double off_after_five_seconds_m(const Airframe& airframe) {
  PhysicsConfig config;
  config.contacts = config.ground_effect = config.downwash = false;
  PhysicsVehicle vehicle = vehicle_at({0, 0, 100}, airframe);
  vehicle.motors_on = true;
  vehicle.start.v_world_mps = {3, -1, 2};
  vehicle.start.omega_body_radps = {2.0, -1.5, 1.0};
  Flight flight(config, {vehicle});

  MrsModel model;
  model.p_m = vehicle.start.p_world_m;
  model.v_mps = vehicle.start.v_world_mps;
  model.omega_radps = vehicle.start.omega_body_radps;
  model.rpm.setConstant(airframe.hover_rotor_speed_radps() / kRadps_per_rpm);
  double tilted_most_rad = 0.0;
  for (int half_second = 0; half_second < 10; ++half_second) {
    const Eigen::Vector4d command = command_at(half_second);
    for (int i = 0; i < 4; ++i) flight.commands[0][i] = command[i];
    flight.run(0.5);
    for (int i = 0; i < 2500; ++i) model.step(command, 2e-4);
    tilted_most_rad = std::max(tilted_most_rad, std::acos(std::clamp(model.R(2, 2), -1.0, 1.0)));
  }
  EXPECT_GT(tilted_most_rad, 2.0) << "the vehicle tumbles";
  EXPECT_GT((model.p_m - vehicle.start.p_world_m).norm(), 5.0);
  return (flight.state().p_world_m - model.p_m).norm();
}

TEST(PublishedModel, MatchesFiveTumblingSecondsWithinMillimeters) {
  const double off_m = off_after_five_seconds_m(x500_of_that_model());
  EXPECT_LT(off_m, 0.012);
  Airframe other = x500_of_that_model();
  other.motor_time_constant_up_s *= 1.05;
  EXPECT_GT(off_after_five_seconds_m(other), 0.012) << "5 % of one constant are noticed";
}

}  // namespace
}  // namespace swiftlet::sim
