// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/orca.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "swiftlet/core/math/random.hpp"
#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

using testing::GuidanceDriver;

constexpr double kDistance_m = 1.1, kHorizon_s = 4.0;

Vector3 drawn(const Random& random, std::uint32_t i, std::uint32_t what, double half) {
  const double x = random.uniform(-half, half, i, 3 * what), y = random.uniform(-half, half, i, 3 * what + 1);
  return {x, y, random.uniform(-half, half, i, 3 * what + 2)};
}

/// Least distance of two over the horizon, at these velocities.
double least_m(const Vector3& to_other_m, const Vector3& v_mps) {
  const double along_s = std::clamp(to_other_m.dot(v_mps) / std::max(1e-12, v_mps.squaredNorm()), 0.0, kHorizon_s);
  return (to_other_m - along_s * v_mps).norm();
}

// Both take half of the change: just so far that they pass at the distance, by brute force over many pairs.
TEST(Orca, PassesAtExactlyTheSafetyDistance) {
  const Random random(5, "orca");
  int num_changed = 0;
  for (std::uint32_t i = 0; i < 5000; ++i) {
    const Vector3 to_m = drawn(random, i, 0, 6.0), v_mps = drawn(random, i, 1, 2.0),
                  other_mps = drawn(random, i, 2, 2.0);
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
  const std::vector<OrcaPlane> planes = {{{0.5, 0.0, 0.0}, -Vector3::UnitX()},
                                         {{0.0, 0.2, 0.0}, Vector3(0.3, 1.0, 0.2).normalized()}};
  std::vector<Vector3> scratch;
  const Vector3 wanted(2.0, -1.0, 0.3), v = orca_velocity(planes, wanted, 1.5, scratch);
  const auto keeps = [&](const Vector3& u, double slack) {
    return u.norm() <= 1.5 + slack && std::all_of(planes.begin(), planes.end(), [&](const OrcaPlane& plane) {
             return plane.normal_local.dot(u - plane.point_local_mps) >= -slack;
           });
  };
  EXPECT_TRUE(keeps(v, 0.01));
  const Random random(2, "orca");
  for (std::uint32_t i = 0; i < 5000; ++i) {
    const Vector3 u = drawn(random, i, 0, 1.5);
    if (!keeps(u, 0.0)) continue;
    ASSERT_GE((u - wanted).norm(), (v - wanted).norm() - 0.02);
  }
}

TEST(Orca, FindsNearestVelocityOnConstraintIntersection) {
  const Random random(3, "orca");
  std::vector<Vector3> scratch;
  for (std::uint32_t k = 0; k < 30; ++k) {
    const Vector3 normal = drawn(random, k, 0, 1.0).normalized();
    const std::vector<OrcaPlane> planes = {{random.uniform(-0.5, 1.2, k, 20) * normal, normal}};
    const Vector3 wanted = 2.5 * drawn(random, k, 1, 1.0).normalized(), v = orca_velocity(planes, wanted, 1.5, scratch);
    ASSERT_LE(v.norm(), 1.5 + 1e-6) << k;
    ASSERT_GE(normal.dot(v - planes[0].point_local_mps), -0.01) << k;
    for (std::uint32_t i = 0; i < 3000; ++i) {
      const Vector3 u = drawn(random, i, 2, 1.5);
      if (u.norm() > 1.5 || normal.dot(u - planes[0].point_local_mps) < 0.0) continue;
      ASSERT_GE((u - wanted).norm(), (v - wanted).norm() - 0.02) << k;
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
