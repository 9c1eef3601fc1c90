// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/control/controller.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "swiftlet/core/control/reference_governor.hpp"
#include "swiftlet/core/math/random.hpp"
#include "tests/support/airframes.hpp"
#include "tests/support/fine_plant.hpp"

namespace swiftlet {
namespace {

using testing::FinePlant;
using testing::NamedAirframe;
constexpr double kDt = 0.004;

double rotor_speed(const Airframe& a, double command) {
  return a.rotor_speed_min_radps + command * (a.rotor_speed_max_radps - a.rotor_speed_min_radps);
}

class EveryAirframe : public ::testing::TestWithParam<NamedAirframe> {
 protected:
  const Airframe airframe = GetParam().airframe;
};

TEST_P(EveryAirframe, HoversAtRotorSpeedBalancingWeight) {
  MultirotorController controller(airframe, {}, kDt);
  FinePlant plant(airframe);
  const Reference here;
  const auto& command = controller.step(plant.truth(), here, Vector3::Zero(), kDt);
  const double hover = std::sqrt(airframe.mass_kg * 9.81 / (4 * airframe.thrust_constant_N_per_radps2));
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(rotor_speed(airframe, command[i]), hover, 1e-6 * hover);
}

TEST_P(EveryAirframe, HoldsHoverWithinCentimetersAfterPush) {
  MultirotorController controller(airframe, {}, kDt);
  FinePlant plant(airframe);
  plant.v = {0.5, -0.3, 0.2};
  const Reference here;
  double worst = 0.0;
  for (int i = 0; i < 5000; ++i) {
    plant.advance(controller.step(plant.truth(), here, Vector3::Zero(), kDt), kDt);
    if (i > 2500) worst = std::max(worst, plant.p.norm());
  }
  EXPECT_LT(worst, 0.02);
  EXPECT_LT(plant.omega.norm(), 1e-3) << "no limit cycle";
}

TEST_P(EveryAirframe, HoldsHoverInWindByIntegral) {
  MultirotorController controller(airframe, {}, kDt);
  FinePlant plant(airframe);
  plant.wind = {4.0, 2.0, 0.0};
  for (int i = 0; i < 7500; ++i) plant.advance(controller.step(plant.truth(), {}, Vector3::Zero(), kDt), kDt);
  EXPECT_LT(plant.p.norm(), 0.05);
}

TEST_P(EveryAirframe, SettlesTiltQuicklyWithLittleOvershoot) {
  // A step of the wanted acceleration by g/4 needs a tilt of atan(1/4); feedback of position and velocity is off.
  ControlGainsConfig gains;
  gains.position_radps = 1e-6;
  gains.integral_time_s = 0.0;
  MultirotorController controller(airframe, gains, kDt);
  FinePlant plant(airframe);
  Reference push;
  push.acceleration_mps2 = {0.25 * 9.81, 0.0, 0.0};
  const double wanted = std::atan(0.25);
  double most = 0.0, settled = 0.0;
  for (int i = 1; i <= 250; ++i) {
    plant.advance(controller.step(plant.truth(), push, Vector3::Zero(), kDt), kDt);
    most = std::max(most, plant.tilt_rad());
    if (std::abs(plant.tilt_rad() - wanted) > 0.05 * wanted) settled = i * kDt;
  }
  EXPECT_LT(most, 1.15 * wanted);
  EXPECT_LT(settled, 0.6);
  EXPECT_NEAR(yaw_of(plant.q.toRotationMatrix()), 0.0, 1e-3) << "tilting forward must not turn the heading";
}

/// The most demanding loop within Table IV of Vrba 2025: a lying figure of eight with 8.2 m/s and 4.5 m/s^2 at its
/// peaks.
struct Eight {
  // x = A sin wt, y = B sin 2wt: |v| <= w sqrt(A^2 + 4 B^2), |a| <= w^2 sqrt(A^2 + 16 B^2) (bounds of each axis).
  double w = 0.42, A = 15.0, B = 6.2;
  Reference at(double t) const {
    Reference r;
    r.position_m = {A * std::sin(w * t), B * std::sin(2 * w * t), 3.0 * (1 - std::cos(w * t))};
    r.velocity_mps = {A * w * std::cos(w * t), 2 * B * w * std::cos(2 * w * t), 3.0 * w * std::sin(w * t)};
    r.acceleration_mps2 = {-A * w * w * std::sin(w * t), -4 * B * w * w * std::sin(2 * w * t),
                           3.0 * w * w * std::cos(w * t)};
    return r;
  }
};

TEST_P(EveryAirframe, TracksAgileTrajectoriesWithinThirtyCentimeters) {
  MotionLimitsConfig limits;
  limits.set = MotionLimitsConfig::Set::kAgile;
  ReferenceGovernor governor(limits.resolve());
  MultirotorController controller(airframe, {}, kDt);
  FinePlant plant(airframe);
  governor.reset({});
  Eight eight;
  double sum_sq = 0.0, fastest = 0.0, hardest = 0.0;
  int n = 0;
  for (int i = 0; i < 12000; ++i) {
    const Reference goal = eight.at(i * kDt);
    const Reference& r = governor.step(goal, kDt);
    plant.advance(controller.step(plant.truth(), r, governor.jerk_mps3(), kDt), kDt);
    if (i < 2000) continue;
    fastest = std::max(fastest, goal.velocity_mps.norm());
    hardest = std::max(hardest, goal.acceleration_mps2.norm());
    sum_sq += (plant.p - eight.at((i + 1) * kDt).position_m).squaredNorm();
    ++n;
  }
  EXPECT_GT(fastest, 8.1);
  EXPECT_GT(hardest, 4.4);
  const double rms = std::sqrt(sum_sq / n);
  EXPECT_LT(rms, 0.3);
  RecordProperty("rms_m", std::to_string(rms));
}

TEST_P(EveryAirframe, ComesBackFromUpsideDown) {
  for (const double tilt : {std::numbers::pi, 3.0, 2.0}) {
    MultirotorController controller(airframe, {}, kDt);
    FinePlant plant(airframe);
    plant.q = Eigen::AngleAxisd(tilt, Vector3(1.0, 0.4, 0.0).normalized());
    for (int i = 0; i < 2500; ++i) plant.advance(controller.step(plant.truth(), {}, Vector3::Zero(), kDt), kDt);
    EXPECT_LT(plant.p.norm(), 0.2) << tilt;
    EXPECT_LT(plant.tilt_rad(), 0.05) << tilt;
  }
}

TEST_P(EveryAirframe, SurvivesHugeErrorsAndFliesBack) {
  MultirotorController controller(airframe, {}, kDt);
  FinePlant plant(airframe);
  plant.p = {300.0, -200.0, 50.0};  // the reference stays far away: as after a jump of the estimate
  double worst_tilt = 0.0;
  for (int i = 0; i < 25000; ++i) {
    plant.advance(controller.step(plant.truth(), {}, Vector3::Zero(), kDt), kDt);
    worst_tilt = std::max(worst_tilt, plant.tilt_rad());
  }
  EXPECT_LT(plant.p.norm(), 0.5);
  EXPECT_LT(worst_tilt, 65.0 * std::numbers::pi / 180.0);
}

// A new goal ten times a second, as in flocking. The jerk of the reference alternates at its limit, and the commanded
// torque exceeds that of the rotors again and again.
TEST_P(EveryAirframe, StaysControlledUnderJumpingGoals) {
  const MotionLimits limits;
  ASSERT_EQ(limits.horizontal_jerk_mps3, 40.0);
  for (const double jump_m : {0.05, 0.4}) {
    ReferenceGovernor governor(limits);
    MultirotorController controller(airframe, {}, kDt);
    FinePlant plant(airframe);
    governor.reset({});
    const Random random(1, "test.jumps");
    Reference goal;
    double worst = 0.0;
    for (int i = 0; i < 5000; ++i) {
      if (i % 25 == 0) {
        const auto n = random.normal3(0, i);
        goal.position_m = governor.state().position_m + Vector3(2.0, 0.0, 0.0) + jump_m * Vector3(n[0], n[1], n[2]);
      }
      const Reference& r = governor.step(goal, kDt);
      plant.advance(controller.step(plant.truth(), r, governor.jerk_mps3(), kDt), kDt);
      worst = std::max(worst, (plant.p - governor.state().position_m).norm());
    }
    EXPECT_LT(worst, 1.5) << jump_m;
  }
}

INSTANTIATE_TEST_SUITE_P(Vehicles, EveryAirframe, ::testing::ValuesIn(testing::all_airframes()),
                         [](const auto& vehicle) { return vehicle.param.name; });

// Motor lags of 0.03 s as in mrs_multirotor_simulator and 0.05 s as in its A300, a lag that the plant does not have,
// and ticks of 1 ms and 10 ms.
TEST(MultirotorController, SettlesForAnyLagAndTick) {
  struct Case {
    double model_lag_s, plant_lag_s, tick_s;
  };
  for (const auto& [model_lag_s, plant_lag_s, tick_s] :
       {Case{0.03, 0.03, kDt}, {0.05, 0.05, kDt}, {0.03, 1e-5, kDt}, {0.03, 0.03, 0.001}, {0.03, 0.03, 0.01}}) {
    Airframe model = testing::x500(), truth = model;
    model.motor_time_constant_up_s = model.motor_time_constant_down_s = model_lag_s;
    truth.motor_time_constant_up_s = truth.motor_time_constant_down_s = plant_lag_s;
    MultirotorController controller(model, {}, tick_s);
    FinePlant plant(truth);
    plant.v = {1.0, 0.5, 0.0};
    for (int i = 0; i < static_cast<int>(12.0 / tick_s); ++i) {
      plant.advance(controller.step(plant.truth(), {}, Vector3::Zero(), tick_s), tick_s);
    }
    EXPECT_LT(plant.p.norm(), 0.02) << model_lag_s << ' ' << plant_lag_s << ' ' << tick_s;
    EXPECT_LT(plant.omega.norm(), 2e-3) << model_lag_s << ' ' << plant_lag_s << ' ' << tick_s;
  }
}

TEST(MultirotorController, HoversWithAnyNumberOfRotors) {
  for (const int n : {4, 5, 6, 7, 8}) {
    const Airframe airframe = testing::ring_of_rotors(n);
    MultirotorController controller(airframe, {}, kDt);
    FinePlant plant(airframe);
    Reference goal;
    goal.position_m = {0.5, -0.5, 0.3};
    goal.yaw_rad = 1.0;
    for (int i = 0; i < 4000; ++i) plant.advance(controller.step(plant.truth(), goal, Vector3::Zero(), kDt), kDt);
    EXPECT_LT((plant.p - goal.position_m).norm(), 0.02) << n;
    EXPECT_NEAR(yaw_of(plant.q.toRotationMatrix()), 1.0, 0.01) << n;
  }
}

TEST(MultirotorController, MirroredErrorGivesMirroredCommands) {
  // The X500 is symmetric about the x-z plane when left and right rotors (and their senses) change places.
  const Airframe airframe = testing::x500();
  MultirotorController left(airframe, {}, kDt), right(airframe, {}, kDt);
  FinePlant a(airframe), b(airframe);
  a.p = {0.3, 0.4, -0.1};
  b.p = {0.3, -0.4, -0.1};
  a.v = {0.1, 0.2, 0.3};
  b.v = {0.1, -0.2, 0.3};
  const auto& u = left.step(a.truth(), {}, Vector3::Zero(), kDt);
  const auto& w = right.step(b.truth(), {}, Vector3::Zero(), kDt);
  EXPECT_NEAR(u[0], w[2], 1e-12);
  EXPECT_NEAR(u[1], w[3], 1e-12);
  EXPECT_NEAR(u[2], w[0], 1e-12);
  EXPECT_NEAR(u[3], w[1], 1e-12);
}

TEST(MultirotorController, StopsMotorsOnInvalidInput) {
  MultirotorController controller(testing::x500(), {}, kDt);
  FinePlant plant(testing::x500());
  const double nan = std::nan("");
  StateEstimate estimate = plant.truth();
  Reference reference;
  const auto expect_idle = [&](const auto& commands) {
    for (const double u : commands) EXPECT_EQ(u, 0.0);
  };
  estimate.valid = false;
  expect_idle(controller.step(estimate, reference, Vector3::Zero(), kDt));
  estimate = plant.truth();
  estimate.T_local_body.translation().x() = nan;
  expect_idle(controller.step(estimate, reference, Vector3::Zero(), kDt));
  estimate = plant.truth();
  estimate.omega_body_radps.z() = std::numeric_limits<double>::infinity();
  expect_idle(controller.step(estimate, reference, Vector3::Zero(), kDt));
  reference.yaw_rad = nan;
  expect_idle(controller.step(plant.truth(), reference, Vector3::Zero(), kDt));
  expect_idle(controller.step(plant.truth(), {}, Vector3::Constant(nan), kDt));
  expect_idle(controller.step(plant.truth(), {}, Vector3::Zero(), nan));
  // Recovers at once.
  for (int i = 0; i < 20; ++i) controller.step(plant.truth(), {}, Vector3::Zero(), kDt);
  for (int i = 0; i < 4; ++i) EXPECT_GT(controller.step(plant.truth(), {}, Vector3::Zero(), kDt)[i], 0.2);
}

TEST(MultirotorController, BoundsCommandsForAnyState) {
  const Airframe airframe = testing::x500();
  const Random random(5, "test.controller");
  MultirotorController controller(airframe, {}, kDt);
  for (std::uint32_t i = 0; i < 20000; ++i) {
    StateEstimate e;
    e.valid = true;
    const auto vec = [&](std::uint32_t k, double size) {
      return Vector3(random.uniform(-size, size, i, k), random.uniform(-size, size, i, k + 1),
                     random.uniform(-size, size, i, k + 2));
    };
    e.T_local_body = make_pose(
        vec(0, 1e3), Eigen::Quaterniond(Eigen::AngleAxisd(random.uniform(-3.14, 3.14, i, 3), vec(4, 1).normalized())));
    e.v_local_mps = vec(7, 50);
    e.omega_body_radps = vec(10, 40);
    Reference r;
    r.position_m = vec(13, 1e3);
    r.acceleration_mps2 = vec(16, 20);
    r.yaw_rad = random.uniform(-3.14, 3.14, i, 19);
    const double dt = i % 50 == 0 ? 3.0 : kDt;
    for (const double u : controller.step(e, r, vec(20, 100), dt)) {
      ASSERT_TRUE(u >= 0.0 && u <= 1.0) << u;
    }
  }
}

}  // namespace
}  // namespace swiftlet
