// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "swiftlet/core/control/controller.hpp"
#include "tests/support/airframes.hpp"

namespace swiftlet {
namespace {

constexpr double kTick_s = 0.004, kWeight_mps2 = 9.81;

/// Force and torques that a controller wants in its first tick.
class FirstTick {
 public:
  explicit FirstTick(const Airframe& airframe_in, ControlGainsConfig config = {}) : airframe(airframe_in) {
    config.integral_time_s = 0.0;
    controller = std::make_unique<MultirotorController>(airframe, config, kTick_s);
    estimate.valid = true;
  }
  void turn(double angle_rad, const Vector3& axis) {
    estimate.T_local_body = make_pose(Vector3::Zero(), Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, axis)));
  }
  Wrench wrench(const Vector3& jerk_mps3 = Vector3::Zero()) {
    const auto& commands = controller->step(estimate, reference, jerk_mps3, kTick_s);
    Mixer::Forces force_N{};
    for (int i = 0; i < airframe.num_rotors(); ++i) {
      const double least = airframe.rotor_speed_min_radps, most = airframe.rotor_speed_max_radps;
      force_N[i] =
          airframe.thrust_constant_N_per_radps2 * std::pow(wanted_radps(least + commands[i] * (most - least)), 2);
    }
    return controller->mixer().wrench(force_N);
  }
  /// Rotor speed for which this one is commanded. Compensating half of the lag tau multiplies the change from hover by
  /// (1 - exp(-2 dt / tau)) / (1 - exp(-dt / tau)).
  double wanted_radps(double commanded_radps) const {
    const double hover_radps = airframe.hover_rotor_speed_radps(), change_radps = commanded_radps - hover_radps;
    const double tau_s = change_radps > 0.0 ? airframe.motor_time_constant_up_s : airframe.motor_time_constant_down_s;
    return hover_radps + change_radps / (1.0 + std::exp(-kTick_s / tau_s));
  }
  /// Torque of an angular acceleration.
  double torque_Nm(int axis, double radps2) const { return airframe.inertia_diagonal_kgm2[axis] * radps2; }
  const ControlGains& gains() const { return controller->gains(); }

  Airframe airframe;
  std::unique_ptr<MultirotorController> controller;
  StateEstimate estimate;
  Reference reference;
};

class ControlLaw : public ::testing::TestWithParam<testing::NamedAirframe> {
 protected:
  const Airframe airframe = GetParam().airframe;
  const double weight_N = airframe.mass_kg * kWeight_mps2;
};
INSTANTIATE_TEST_SUITE_P(Vehicles, ControlLaw, ::testing::ValuesIn(testing::all_airframes()),
                         [](const auto& param_info) { return std::string(param_info.param.name); });

TEST_P(ControlLaw, HeadingErrorCommandsOnlyYawTorque) {
  for (const double error_rad : {-0.02, 0.01}) {
    FirstTick tick(airframe);
    tick.reference.yaw_rad = error_rad;
    const Wrench wrench = tick.wrench();
    EXPECT_GT(wrench.torque_body_Nm.z() * error_rad, 0.0);
    EXPECT_LT(wrench.torque_body_Nm.head<2>().norm(), 1e-9);
    EXPECT_NEAR(wrench.thrust_N, weight_N, 1e-6);
  }
}

TEST_P(ControlLaw, TiltCommandsTorqueAndReducedThrust) {
  for (int axis = 0; axis < 2; ++axis) {
    for (const double tilt_rad : {-0.05, 0.03}) {
      FirstTick tick(airframe);
      tick.turn(tilt_rad, Vector3::Unit(axis));
      const Wrench wrench = tick.wrench();
      EXPECT_LT(wrench.torque_body_Nm[axis] * tilt_rad, 0.0);
      EXPECT_NEAR(wrench.torque_body_Nm[1 - axis], 0.0, 1e-9);
      EXPECT_NEAR(wrench.thrust_N, weight_N * std::cos(tilt_rad), 1e-6);
    }
  }
}

// Beyond its bound an error commands no more.
TEST_P(ControlLaw, BoundsRatesAndTilt) {
  ControlGainsConfig config;
  config.yaw_rate_max_degps = 1.0;
  config.tilt_rate_max_degps = 10.0;
  config.tilt_max_deg = 1.0;
  const auto torque_Nm = [&](double yaw_rad, double tilt_rad, double acceleration_mps2) {
    FirstTick tick(airframe, config);
    tick.turn(tilt_rad, Vector3(0.6, 0.8, 0.0));
    tick.reference.yaw_rad = yaw_rad;
    tick.reference.acceleration_mps2 = acceleration_mps2 * Vector3(0.6, 0.8, 0.0);
    return tick.wrench().torque_body_Nm;
  };
  EXPECT_LT((torque_Nm(1.5, 0, 0) - torque_Nm(0.8, 0, 0)).norm(), 1e-9);
  EXPECT_LT((torque_Nm(0, 0.25, 0) - torque_Nm(0, 0.2, 0)).norm(), 1e-9);
  EXPECT_LT((torque_Nm(0, 0, 5.0) - torque_Nm(0, 0, 2.0)).norm(), 1e-9);
  EXPECT_GT((torque_Nm(0, 0, 5.0) - torque_Nm(0, 0, 0.0)).norm(), 1e-4);
}

// Beyond its bound of 6 m/s^2 the feedback commands no more. Slow loops keep the torques small.
TEST_P(ControlLaw, BoundsFeedback) {
  ControlGainsConfig config;
  config.position_radps = 2.5;
  config.attitude_radps = 0.1;
  config.rate_radps = 0.5;
  const auto torque_Nm = [&](double position_m, double acceleration_mps2) {
    FirstTick tick(airframe, config);
    tick.reference.position_m = position_m * Vector3(0.6, 0.8, 0.0);
    tick.reference.acceleration_mps2 = acceleration_mps2 * Vector3(0.6, 0.8, 0.0);
    return tick.wrench().torque_body_Nm;
  };
  EXPECT_LT((torque_Nm(30.0, 0.0) - torque_Nm(0.0, 6.0)).norm(), 1e-9);
  EXPECT_LT((torque_Nm(300.0, 0.0) - torque_Nm(0.0, 6.0)).norm(), 1e-9);
  EXPECT_GT(torque_Nm(0.0, 6.0).norm(), 1.1 * torque_Nm(0.0, 5.0).norm());
}

TEST_P(ControlLaw, KeepsThrustWhenSinking) {
  FirstTick tick(airframe);
  tick.reference.acceleration_mps2.z() = -30.0;
  EXPECT_GT(tick.wrench().thrust_N, 0.05 * weight_N);
  EXPECT_LT(tick.wrench().thrust_N, weight_N);
}

TEST_P(ControlLaw, OuterLoopsAreSlowerThanInner) {
  const ControlGains gains = FirstTick(airframe).gains();
  EXPECT_LT(std::sqrt(gains.position), gains.attitude_body.x() / 2.0);
  EXPECT_LE(gains.attitude_body.x(), gains.rate_body.x() / 4.0 + 1e-12) << "critically damped";
  EXPECT_LE(gains.attitude_body.z(), gains.rate_body.z() / 4.0 + 1e-12);
  EXPECT_LT(gains.rate_body.z(), gains.rate_body.x()) << "yaw torque is scarce";
}

TEST_P(ControlLaw, DampsRatesAndAddsGyroscopicTorque) {
  FirstTick tick(airframe);
  const Vector3 omega(0.3, -0.2, 0.02), inertia = airframe.inertia_diagonal_kgm2;
  tick.estimate.omega_body_radps = omega;
  const Vector3 expected =
      -inertia.cwiseProduct(tick.gains().rate_body.cwiseProduct(omega)) + omega.cross(inertia.cwiseProduct(omega));
  EXPECT_LT((tick.wrench().torque_body_Nm - expected).norm(), 1e-9);
}

TEST_P(ControlLaw, DerivesRatesFromJerkAndYaw) {
  FirstTick tick(airframe);
  tick.reference.yaw_rate_radps = 0.03;
  // Thrust of g that turns by a jerk across it: at jerk / g.
  const Wrench wrench = tick.wrench({0.5, -0.3, 2.0});
  EXPECT_NEAR(wrench.torque_body_Nm.x(), tick.torque_Nm(0, tick.gains().rate_body.x() * 0.3 / kWeight_mps2), 1e-9);
  EXPECT_NEAR(wrench.torque_body_Nm.y(), tick.torque_Nm(1, tick.gains().rate_body.y() * 0.5 / kWeight_mps2), 1e-9);
  EXPECT_NEAR(wrench.torque_body_Nm.z(), tick.torque_Nm(2, tick.gains().rate_body.z() * 0.03), 1e-9);
}

/// Tilt commanded in the first tick, about x and y; below its bound.
Eigen::Vector2d wanted_tilt_rad(FirstTick& tick) {
  const Wrench wrench = tick.wrench();
  return {wrench.torque_body_Nm.x() / tick.torque_Nm(0, tick.gains().rate_body.x() * tick.gains().attitude_body.x()),
          wrench.torque_body_Nm.y() / tick.torque_Nm(1, tick.gains().rate_body.y() * tick.gains().attitude_body.y())};
}

TEST_P(ControlLaw, PositionAndVelocityErrorsTiltThrust) {
  ControlGainsConfig config;
  config.position_radps = 0.5;
  config.position_damping = 0.8;
  Airframe dragless = airframe;
  dragless.body_drag_area_m2.setZero();
  dragless.rotor_drag_N_per_radps_mps = 0.0;
  FirstTick tick(dragless, config);
  tick.reference.position_m = {0.4, 0.0, 0.2};
  tick.reference.velocity_mps = {0.0, -0.3, 0.0};
  tick.reference.acceleration_mps2 = {0.1, 0.0, 0.0};
  // a = w^2 e_p + 2 zeta w e_v + a_ref
  const Vector3 a(0.25 * 0.4 + 0.1, -0.8 * 0.3, 0.25 * 0.2);
  const double level = std::hypot(a.x(), a.y()), tilt = std::atan2(level, kWeight_mps2 + a.z());
  const Eigen::Vector2d wanted = wanted_tilt_rad(tick);
  EXPECT_NEAR(wanted.x(), -tilt * a.y() / level, 1e-9);
  EXPECT_NEAR(wanted.y(), tilt * a.x() / level, 1e-9);
}

// The feedforward equals the drag at v in still air: half rho |v| v A, and the drag of each turning rotor.
TEST_P(ControlLaw, FeedsForwardDragOfReferenceVelocity) {
  Airframe draggy = airframe;
  draggy.body_drag_area_m2 = {0.03, 0.02, 0.05};
  draggy.rotor_drag_N_per_radps_mps = 1e-4;
  FirstTick tick(draggy);
  const Vector3 v(0.6, 0.8, 0.0);
  tick.reference.velocity_mps = tick.estimate.v_local_mps = v;
  const double speeds_radps = draggy.num_rotors() * draggy.hover_rotor_speed_radps();
  const Vector3 drag_N = 0.5 * 1.225 * 1.0 * draggy.body_drag_area_m2.cwiseProduct(v) + 1e-4 * speeds_radps * v;
  const Vector3 a = drag_N / draggy.mass_kg;
  const double level = std::hypot(a.x(), a.y()), tilt = std::atan2(level, kWeight_mps2);
  const Eigen::Vector2d wanted = wanted_tilt_rad(tick);
  EXPECT_NEAR(wanted.x(), -tilt * a.y() / level, 1e-6);
  EXPECT_NEAR(wanted.y(), tilt * a.x() / level, 1e-6);
}

}  // namespace
}  // namespace swiftlet
