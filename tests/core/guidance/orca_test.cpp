// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/orca.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/core/guidance/guidance_driver.hpp"
#include "tests/support/draws.hpp"

namespace swiftlet {
namespace {

using testing::Draws;
using testing::GuidanceDriver;

constexpr double kDistance_m = 1.1, kHorizon_s = 4.0;

/// Least distance of two over the horizon, at these velocities.
double least_m(const Vector3& to_other_m, const Vector3& v_mps) {
  const double along_s = std::clamp(to_other_m.dot(v_mps) / std::max(1e-12, v_mps.squaredNorm()), 0.0, kHorizon_s);
  return (to_other_m - along_s * v_mps).norm();
}

// Both take half of the change: just so far that they pass at the distance, by brute force over many pairs.
TEST(Orca, PassesAtExactlyTheSafetyDistance) {
  Draws draws("orca", 5);
  int num_changed = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vector3 to_m = draws.vector(6.0), v_mps = draws.vector(2.0), other_mps = draws.vector(2.0);
    if (to_m.norm() < kDistance_m + 0.05) continue;
    const OrcaPlane own = orca_plane(to_m, v_mps, other_mps, kDistance_m, kHorizon_s, 0.2);
    const OrcaPlane theirs = orca_plane(-to_m, other_mps, v_mps, kDistance_m, kHorizon_s, 0.2);
    const double before_m = least_m(to_m, v_mps - other_mps);
    const double after_m = least_m(to_m, own.point_local_mps - theirs.point_local_mps);
    EXPECT_NEAR(after_m, kDistance_m, 1e-6) << i;
    const bool keeps = own.normal_local.dot(v_mps - own.point_local_mps) >= 0.0;
    EXPECT_EQ(keeps, before_m >= kDistance_m) << i;
    num_changed += keeps ? 0 : 1;
  }
  EXPECT_GT(num_changed, 20);
}

TEST(Orca, SeparatesOverlappingVehiclesWithinOneStep) {
  const Vector3 to_m(0.6, 0.0, 0.0);
  const OrcaPlane own = orca_plane(to_m, Vector3::Zero(), Vector3::Zero(), kDistance_m, kHorizon_s, 0.2);
  const OrcaPlane theirs = orca_plane(-to_m, Vector3::Zero(), Vector3::Zero(), kDistance_m, kHorizon_s, 0.2);
  EXPECT_NEAR((to_m - 0.2 * (own.point_local_mps - theirs.point_local_mps)).norm(), kDistance_m, 1e-9);
}

TEST(Orca, FindsNearestVelocityWithinAllConstraints) {
  std::vector<Vector3> scratch;
  for (std::uint32_t round = 0; round < 30; ++round) {
    Draws draws("orca", 2, round);
    std::vector<OrcaPlane> planes = {{{0.5, 0.0, 0.0}, -Vector3::UnitX()},
                                     {{0.0, 0.2, 0.0}, Vector3(0.3, 1.0, 0.2).normalized()}};
    if (round > 0) {
      const Vector3 normal = draws.vector(1.0).normalized();
      planes = {{draws.between(-0.5, 1.2) * normal, normal}};
    }
    const Vector3 wanted = 2.5 * draws.vector(1.0).normalized(), v = orca_velocity(planes, wanted, 1.5, scratch);
    const auto keeps = [&](const Vector3& u, double slack) {
      return u.norm() <= 1.5 + slack && std::all_of(planes.begin(), planes.end(), [&](const OrcaPlane& plane) {
               return plane.normal_local.dot(u - plane.point_local_mps) >= -slack;
             });
    };
    ASSERT_TRUE(keeps(v, 0.01)) << round;
    for (int i = 0; i < 3000; ++i) {
      const Vector3 u = draws.vector(1.5);
      if (!keeps(u, 0.0)) continue;
      ASSERT_GE((u - wanted).norm(), (v - wanted).norm() - 0.02) << round;
    }
  }
}

TEST(Orca, RelaxesInfeasiblePlanesEqually) {
  const std::vector<OrcaPlane> planes = {{{1.0, 0.0, 0.0}, Vector3::UnitX()}, {{-1.0, 0.0, 0.0}, -Vector3::UnitX()}};
  std::vector<Vector3> scratch;
  EXPECT_NEAR(orca_velocity(planes, {0.0, 0.5, 0.0}, 2.0, scratch).x(), 0.0, 0.4);
}

TEST(Orca, ReachesGoalPastAStationaryVehicle) {
  OrcaConfig config;
  config.goal_m = {12.0, 0.0, 5.0};
  GuidanceDriver driver("orca", config, {0.0, 0.0, 5.0});
  const Vector3 other_m(6.0, 0.0, 5.0);
  double nearest_m = 10.0, fastest_mps = 0.0;
  for (int i = 0; i < 400 && driver.out.mission != MissionStatus::kDone; ++i) {
    driver.sees(1, other_m);
    const Vector3 v_mps = driver.step().goal.position_m - driver.p_m();  // its goal lies a second ahead
    driver.estimate.v_local_mps = v_mps;
    driver.put(driver.p_m() + driver.dt_s * v_mps);
    nearest_m = std::min(nearest_m, (driver.p_m() - other_m).norm());
    fastest_mps = std::max(fastest_mps, v_mps.norm());
  }
  EXPECT_EQ(driver.out.mission, MissionStatus::kDone);
  EXPECT_GT(nearest_m, 0.9) << "the other one does not do its half";
  EXPECT_LT(fastest_mps, config.speed_mps + 0.01);
}

}  // namespace
}  // namespace swiftlet
