// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/vehicle_state.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace swiftlet::sim {
namespace {

// p = c0 + c1 t + c2 t^2 + c3 t^3 on each axis.
VehicleState on_a_cubic(double t_s) {
  const Vector3 c0(1, -2, 3), c1(4, 0.5, -1), c2(-0.7, 2, 0.1), c3(0.2, -0.4, 0.9);
  VehicleState state;
  state.t = from_seconds(t_s);
  state.p_world_m = c0 + t_s * (c1 + t_s * (c2 + t_s * c3));
  state.v_world_mps = c1 + t_s * (2.0 * c2 + t_s * 3.0 * c3);
  state.q_world_body = Eigen::AngleAxisd(0.3 + 0.5 * t_s, Vector3(1, 2, 3).normalized());
  state.omega_body_radps = Vector3(0.1, 0.2, 0.3) * t_s;
  for (int i = 0; i < kMaxRotors; ++i) {
    state.rotor_speed_radps[i] = 100.0 + i * t_s;
    state.rotor_angle_rad[i] = -i * 50.0 * t_s;
  }
  return state;
}

TEST(VehicleState, PositionsBetweenTwoStatesFollowTheCubicThroughThem) {
  const VehicleState a = on_a_cubic(0.4), b = on_a_cubic(1.6);
  for (const double t_s : {0.4, 0.5, 0.9, 1.0, 1.37, 1.6}) {
    const VehicleState expected = on_a_cubic(t_s), between = interpolate(a, b, from_seconds(t_s));
    EXPECT_EQ(between.t, expected.t);
    EXPECT_TRUE(between.p_world_m.isApprox(expected.p_world_m, 1e-12)) << t_s;
    EXPECT_LT(between.q_world_body.angularDistance(expected.q_world_body), 1e-7) << t_s;
    EXPECT_TRUE(between.omega_body_radps.isApprox(expected.omega_body_radps, 1e-12)) << t_s;
    for (int i = 0; i < kMaxRotors; ++i) {
      EXPECT_NEAR(between.rotor_speed_radps[i], expected.rotor_speed_radps[i], 1e-9);
      EXPECT_NEAR(between.rotor_angle_rad[i], expected.rotor_angle_rad[i], 1e-9);
    }
  }
}

TEST(VehicleState, OutsideOfTheTwoStatesTheNearerOneHolds) {
  const VehicleState a = on_a_cubic(0.4), b = on_a_cubic(1.6);
  EXPECT_EQ(interpolate(a, b, from_seconds(0.1)).p_world_m, a.p_world_m);
  EXPECT_EQ(interpolate(a, b, from_seconds(2.0)).p_world_m, b.p_world_m);
}

TEST(StateHistory, AnswersAsTheTwoStatesAroundTheTime) {
  StateHistory history(2, 8);
  for (int i = 0; i < 20; ++i) {
    history.push(0, on_a_cubic(0.1 * i));
    history.push(1, on_a_cubic(3.0 + 0.1 * i));
  }
  EXPECT_EQ(history.latest(0).t, from_seconds(1.9));
  EXPECT_EQ(history.latest(1).t, from_seconds(4.9));
  for (const double t_s : {1.2, 1.23, 1.5, 1.67, 1.899, 1.9}) {
    EXPECT_TRUE(history.at(0, from_seconds(t_s)).p_world_m.isApprox(on_a_cubic(t_s).p_world_m, 1e-12)) << t_s;
    EXPECT_TRUE(history.at(1, from_seconds(t_s + 3.0)).p_world_m.isApprox(on_a_cubic(t_s + 3.0).p_world_m, 1e-12));
  }
  EXPECT_EQ(history.at(0, from_seconds(5.0)).t, from_seconds(1.9));
}

}  // namespace
}  // namespace swiftlet::sim
