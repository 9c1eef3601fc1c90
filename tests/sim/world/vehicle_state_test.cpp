// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/vehicle_state.hpp"

#include <gtest/gtest.h>

#include <algorithm>

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

TEST(VehicleState, InterpolatesPositionsCubically) {
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

TEST(VehicleState, HoldsTheNearerStateOutside) {
  const VehicleState a = on_a_cubic(0.4), b = on_a_cubic(1.6);
  EXPECT_EQ(interpolate(a, b, from_seconds(0.1)).p_world_m, a.p_world_m);
  EXPECT_EQ(interpolate(a, b, from_seconds(2.0)).p_world_m, b.p_world_m);
}

TEST(VehicleState, InterpolatesVelocitiesAndTimesLinearly) {
  VehicleState a, b;
  a.t = 1'000;
  b.t = 5'000;
  a.v_world_mps = {1, -2, 3};
  b.v_world_mps = {5, 6, -1};
  for (const TimeNs t : {1'000, 2'000, 4'500, 5'000}) {
    const double s = static_cast<double>(t - 1'000) / 4'000.0;
    EXPECT_TRUE(interpolate(a, b, t).v_world_mps.isApprox((1.0 - s) * a.v_world_mps + s * b.v_world_mps, 1e-12));
    EXPECT_EQ(interpolate(a, b, t).t, t);
  }
  EXPECT_EQ(interpolate(a, b, 999).t, 1'000);
  EXPECT_EQ(interpolate(a, b, 5'001).t, 5'000);
  b.t = a.t;  // two states of one time: the first
  EXPECT_EQ(interpolate(a, b, 1'000).v_world_mps, a.v_world_mps);
  EXPECT_EQ(interpolate(a, b, 2'000).v_world_mps, a.v_world_mps);
}

// Reference: a list of all pushed states, searched from its end.
TEST(StateHistory, MatchesAListOfLatestStates) {
  for (const int capacity : {0, 2, 3, 7}) {
    for (const int pushed : {1, 2, 5, 20}) {
      StateHistory history(3, capacity);
      EXPECT_EQ(history.num_vehicles(), 3);
      EXPECT_EQ(history.at(1, 5).t, 0) << "nothing yet";
      std::vector<VehicleState> list;
      for (int i = 0; i < pushed; ++i) {
        list.push_back(on_a_cubic(0.1 * i + 0.03 * (i % 3)));
        history.push(1, list.back());
        history.push(2, on_a_cubic(7.0 + i));
      }
      const auto kept = static_cast<std::size_t>(std::min(pushed, std::max(capacity, 2)));
      const std::size_t oldest = list.size() - kept;
      EXPECT_EQ(history.latest(1).t, list.back().t);
      EXPECT_EQ(history.latest(2).t, on_a_cubic(7.0 + pushed - 1).t);
      for (TimeNs t = list[oldest].t; t < list.back().t + 50'000'000; t += 7'000'000) {
        VehicleState expected = list.back();
        for (std::size_t i = oldest; i + 1 < list.size(); ++i) {
          if (t >= list[i].t && t < list[i + 1].t) expected = interpolate(list[i], list[i + 1], t);
        }
        EXPECT_EQ(history.at(1, t).t, expected.t);
        EXPECT_TRUE(history.at(1, t).p_world_m.isApprox(expected.p_world_m, 1e-12));
      }
      for (std::size_t i = oldest; i < list.size(); ++i)
        EXPECT_EQ(history.at(1, list[i].t).p_world_m, list[i].p_world_m);
      if (kept < static_cast<std::size_t>(std::max(capacity, 2))) {
        EXPECT_EQ(history.at(1, list[0].t - 1'000).t, list[0].t) << "before the first";
      }
    }
  }
}

}  // namespace
}  // namespace swiftlet::sim
