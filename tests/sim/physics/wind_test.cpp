// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/wind.hpp"

#include <gtest/gtest.h>

#include "tests/sim/physics/flight.hpp"

namespace swiftlet::sim {
namespace {

WindConfig gusty(const Vector3& mean_mps = Vector3::Zero()) {
  WindConfig wind;
  wind.gusts = true;
  wind.mean_mps = mean_mps;
  return wind;
}

TEST(Dryden, ScalesMatchStandardAtTenMeters) {
  // 32.8 ft: L_u = h / (0.177 + 0.000823 h)^1.2 = 221 ft, sigma_u / sigma_w = 1.89.
  const DrydenScales scales = dryden_scales(10.0, 7.7);
  EXPECT_NEAR(scales.scale_length_m.x(), 67.0, 1.0);
  EXPECT_EQ(scales.scale_length_m.x(), scales.scale_length_m.y());
  EXPECT_NEAR(scales.scale_length_m.z(), 10.0, 1e-9);
  EXPECT_NEAR(scales.sigma_mps.z(), 0.77, 1e-9);
  EXPECT_NEAR(scales.sigma_mps.x() / scales.sigma_mps.z(), 1.89, 0.01);
  // Clamped to 10 ft and 1000 ft.
  EXPECT_EQ(dryden_scales(0.0, 7.7).scale_length_m.x(), dryden_scales(3.0, 7.7).scale_length_m.x());
  EXPECT_NEAR(dryden_scales(1e4, 7.7).scale_length_m.z(), 304.8, 1e-9);
  EXPECT_NEAR(dryden_scales(1e4, 7.7).scale_length_m.x(), 304.8, 0.1);  // isotropic there
}

TEST(Dryden, GustsMatchTheStandardStatistics) {
  // Whatever the step: the discretization is exact.
  for (const double dt_s : {0.02, 0.5}) {
    Gusts gusts(gusty(), 7, "uav1");
    const double speed = 10.0;
    const DrydenScales scales = dryden_scales(10.0, 7.7);
    const double meters_a_step = speed * dt_s;
    const int count = static_cast<int>(2.0e6 / meters_a_step / (dt_s < 0.1 ? 8.0 : 1.0));
    std::vector<Vector3> series(count);
    for (int n = 0; n < count; ++n) series[n] = gusts.advance(n, dt_s, 10.0, speed);
    Vector3 mean = Vector3::Zero();
    for (const Vector3& g : series) mean += g / count;
    for (int axis = 0; axis < 3; ++axis) {
      // exp(-1) after L_u for u, after half of the length for v and w.
      const double length = scales.scale_length_m[axis] * (axis == 0 ? 1.0 : 0.5);
      const int lag = static_cast<int>(std::lround(length / meters_a_step));
      double variance = 0.0;
      double covariance = 0.0;
      for (int n = 0; n + lag < count; ++n) {
        variance += (series[n][axis] - mean[axis]) * (series[n][axis] - mean[axis]) / (count - lag);
        covariance += (series[n][axis] - mean[axis]) * (series[n + lag][axis] - mean[axis]) / (count - lag);
      }
      const double independent = count * meters_a_step / (2 * length);
      EXPECT_NEAR(std::sqrt(variance) / scales.sigma_mps[axis], 1.0, 4.0 / std::sqrt(2 * independent));
      EXPECT_NEAR(covariance / variance, std::exp(-lag * meters_a_step / length), 4.0 / std::sqrt(independent));
      EXPECT_NEAR(mean[axis], 0.0, 4.0 * scales.sigma_mps[axis] / std::sqrt(independent));
    }
  }
}

TEST(Dryden, IsStrongestAlongTheMeanWind) {
  // Against (0, -5, 0) the longitudinal axis is y: same numbers as u in the still case's x.
  Gusts still(gusty(), 3, "uav1");
  Gusts south(gusty({0, -5, 0}), 3, "uav1");
  const Vector3 a = still.advance(0, 0.001, 10.0, 0.0);
  const Vector3 b = south.advance(0, 0.001, 10.0, 0.0);
  EXPECT_NEAR(b.y(), -a.x(), 1e-12);
  EXPECT_NEAR(b.x(), a.y(), 1e-12);
  EXPECT_NEAR(b.z(), a.z(), 1e-12);
}

TEST(Dryden, VehiclesHaveIndependentGusts) {
  const PhysicsVehicle one = vehicle_at({0, 0, 10}, test_quad(), "one");
  const PhysicsVehicle two = vehicle_at({100, 0, 10}, test_quad(), "two");
  const PhysicsConfig config;
  Flight alone(config, {two}, nullptr, gusty());
  Flight both(config, {one, two}, nullptr, gusty());
  Flight other_seed(config, {two}, nullptr, gusty(), 2);
  EXPECT_GT(alone.world.wind_world_mps(0).norm(), 0.0);  // from the first moment
  alone.run(0.2);
  both.run(0.2);
  other_seed.run(0.2);
  EXPECT_EQ(alone.world.wind_world_mps(0), both.world.wind_world_mps(1));
  EXPECT_EQ(alone.state(0).p_world_m, both.state(1).p_world_m);
  EXPECT_NE(both.world.wind_world_mps(0), both.world.wind_world_mps(1));
  EXPECT_NE(alone.world.wind_world_mps(0), other_seed.world.wind_world_mps(0));
}

}  // namespace
}  // namespace swiftlet::sim
