// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "swiftlet/core/control/controller.hpp"
#include "tests/support/airframes.hpp"

namespace swiftlet {
namespace {

constexpr double kTick_s = 0.004, kWeight_mps2 = 9.81, kRadPerDegree = std::numbers::pi / 180.0;

/// Force and torques that a controller commands in its first tick. Its motors have no lead, so that the commands are
/// the wanted speeds.
class FirstTick {
 public:
  explicit FirstTick(const Airframe& airframe_in, ControlGainsConfig config = {}) : airframe(airframe_in) {
    config.motor_lead = 0.0;
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
      force_N[i] = airframe.thrust_constant_N_per_radps2 * std::pow(least + commands[i] * (most - least), 2);
    }
    return controller->mixer().wrench(force_N);
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
    EXPECT_NEAR(wrench.torque_body_Nm.z(),
                tick.torque_Nm(2, tick.gains().rate_body.z() * tick.gains().attitude_body.z() * error_rad), 1e-9);
    EXPECT_LT(wrench.torque_body_Nm.head<2>().norm(), 1e-9);
    EXPECT_NEAR(wrench.thrust_N, weight_N, 1e-6);
  }
}

TEST_P(ControlLaw, BoundsCommandedYawRate) {
  ControlGainsConfig config;
  config.yaw_rate_max_degps = 1.0;
  for (const double sign : {-1.0, 1.0}) {
    FirstTick tick(airframe, config);
    tick.reference.yaw_rad = 1.5 * sign;
    EXPECT_NEAR(tick.wrench().torque_body_Nm.z(),
                sign * tick.torque_Nm(2, tick.gains().rate_body.z() * 1.0 * kRadPerDegree), 1e-9);
  }
}

TEST_P(ControlLaw, TiltCommandsTorqueAndReducedThrust) {
  for (int axis = 0; axis < 2; ++axis) {
    for (const double tilt_rad : {-0.05, 0.03}) {
      FirstTick tick(airframe);
      tick.turn(tilt_rad, Vector3::Unit(axis));
      const Wrench wrench = tick.wrench();
      EXPECT_NEAR(wrench.torque_body_Nm[axis],
                  -tick.torque_Nm(axis, tick.gains().rate_body[axis] * tick.gains().attitude_body[axis] * tilt_rad),
                  1e-9);
      EXPECT_NEAR(wrench.torque_body_Nm[1 - axis], 0.0, 1e-9);
      EXPECT_NEAR(wrench.thrust_N, weight_N * std::cos(tilt_rad), 1e-6);
    }
  }
}

TEST_P(ControlLaw, BoundsCommandedTiltRate) {
  ControlGainsConfig config;
  config.tilt_rate_max_degps = 10.0;
  FirstTick tick(airframe, config);
  tick.turn(0.2, Vector3(0.6, 0.8, 0.0));
  const Wrench wrench = tick.wrench();
  EXPECT_NEAR(wrench.torque_body_Nm.x(), -tick.torque_Nm(0, tick.gains().rate_body.x() * 0.6 * 10.0 * kRadPerDegree),
              1e-9);
  EXPECT_NEAR(wrench.torque_body_Nm.y(), -tick.torque_Nm(1, tick.gains().rate_body.y() * 0.8 * 10.0 * kRadPerDegree),
              1e-9);
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
  config.drag_compensation = false;
  FirstTick tick(airframe, config);
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

TEST_P(ControlLaw, BoundsTiltForAnyDemand) {
  ControlGainsConfig config;
  config.tilt_max_deg = 1.0;
  FirstTick tick(airframe, config);
  tick.reference.acceleration_mps2 = {3.0, 4.0, 0.0};
  const Eigen::Vector2d wanted = wanted_tilt_rad(tick);
  EXPECT_NEAR(wanted.x(), -0.8 * kRadPerDegree, 1e-9);
  EXPECT_NEAR(wanted.y(), 0.6 * kRadPerDegree, 1e-9);
}

TEST_P(ControlLaw, FeedbackIsBounded) {
  ControlGainsConfig config;
  config.feedback_max_mps2 = 0.2;
  config.drag_compensation = false;
  FirstTick tick(airframe, config);
  tick.reference.position_m = {300.0, 0.0, 0.0};
  EXPECT_NEAR(wanted_tilt_rad(tick).y(), std::atan2(0.2, kWeight_mps2), 1e-9);
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

TEST_P(ControlLaw, KeepsFifthOfWeightWhenSinking) {
  FirstTick tick(airframe);
  tick.reference.acceleration_mps2.z() = -30.0;
  const double least_N =
      airframe.num_rotors() * airframe.thrust_constant_N_per_radps2 * std::pow(airframe.rotor_speed_min_radps, 2);
  EXPECT_NEAR(tick.wrench().thrust_N, std::max(0.2 * weight_N, least_N), 1e-6);
}

TEST_P(ControlLaw, OuterLoopsAreSlowerThanInner) {
  const ControlGains gains = FirstTick(airframe).gains();
  EXPECT_NEAR(gains.attitude_body.x(), gains.rate_body.x() / 4.0, 1e-12) << "critically damped";
  EXPECT_NEAR(gains.attitude_body.z(), gains.rate_body.z() / 4.0, 1e-12);
  EXPECT_NEAR(gains.rate_body.z(), gains.rate_body.x() / 4.0, 1e-12) << "yaw torque is scarce";
  const double position = std::sqrt(gains.position);
  EXPECT_NEAR(position, std::min(gains.attitude_body.x() / 2.5, 2.5), 1e-12);
  EXPECT_NEAR(gains.velocity, 2.0 * ControlGainsConfig{}.position_damping * position, 1e-12);
}

TEST(ControlGains, RateLoopIsHalfInverseLag) {
  Airframe airframe = testing::all_airframes().front().airframe;
  airframe.motor_time_constant_up_s = 0.03;
  airframe.motor_time_constant_down_s = 0.05;
  ControlGainsConfig config;
  config.motor_lead = 0.25;
  const auto rate = [&](double tick_s) { return MultirotorController(airframe, config, tick_s).gains().rate_body.x(); };
  EXPECT_NEAR(rate(0.004), 0.5 / (0.75 * 0.04 + 1.5 * 0.004), 1e-9);
  EXPECT_NEAR(rate(1.0), 4.0, 1e-12) << "never slower";
  airframe.motor_time_constant_up_s = airframe.motor_time_constant_down_s = 1e-4;
  EXPECT_NEAR(rate(0.001), 35.0, 1e-12) << "never faster";
}

/// A vehicle below its goal, and the command of its controller beyond carrying the weight.
struct Hanging {
  Hanging(ControlGainsConfig config, double below_m) {
    config.motor_lead = 0.0;
    controller = std::make_unique<MultirotorController>(airframe, config, kTick_s);
    estimate.valid = true;
    reference.position_m.z() = below_m;
  }
  double up_mps2() {
    const auto& commands = controller->step(estimate, reference, Vector3::Zero(), kTick_s);
    double sum_N = 0.0;
    for (int i = 0; i < airframe.num_rotors(); ++i) {
      const double least = airframe.rotor_speed_min_radps, most = airframe.rotor_speed_max_radps;
      sum_N += airframe.thrust_constant_N_per_radps2 * std::pow(least + commands[i] * (most - least), 2);
    }
    return sum_N / airframe.mass_kg - kWeight_mps2;
  }
  Airframe airframe = testing::all_airframes().front().airframe;
  std::unique_ptr<MultirotorController> controller;
  StateEstimate estimate;
  Reference reference;
};

// The integral part grows with the error up to its bound.
TEST(ControlIntegral, GrowsWithErrorUpToBound) {
  ControlGainsConfig config;
  config.integral_max_mps2 = 0.05;
  Hanging hanging(config, 0.01);
  const ControlGains& gains = hanging.controller->gains();
  for (int i = 1; i <= 5000; ++i) {
    const double integral = std::min(0.05, gains.integral * kTick_s * i * 0.01);
    ASSERT_NEAR(hanging.up_mps2(), gains.position * 0.01 + integral, 1e-6) << i;
  }
  EXPECT_GT(gains.integral * kTick_s * 5000 * 0.01, 0.05);
}

TEST(ControlIntegral, FreezesWhileFeedbackSaturates) {
  for (const double feedback_max_mps2 : {0.4, 3.0}) {
    ControlGainsConfig config;
    config.position_radps = 2.0;
    config.feedback_max_mps2 = feedback_max_mps2;
    Hanging below(config, 0.25 * 0.99 * feedback_max_mps2), at(config, 0.25 * 1.01 * feedback_max_mps2);
    for (int i = 0; i < 100; ++i) below.up_mps2(), at.up_mps2();
    const double integral = below.controller->gains().integral * kTick_s * 101 * 0.25 * 0.99 * feedback_max_mps2;
    EXPECT_NEAR(below.up_mps2(), 0.99 * feedback_max_mps2 + integral, 1e-6);
    EXPECT_NEAR(at.up_mps2(), feedback_max_mps2, 1e-6);
  }
}

}  // namespace
}  // namespace swiftlet
