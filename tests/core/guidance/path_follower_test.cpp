// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flight/path_follower.hpp"

#include <gtest/gtest.h>

#include "core/guidance/path_overlay.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using Outcome = PathFollower::Outcome;

/// A vehicle at a position set by the test, above a map that the test changes.
struct FollowedFlight {
  FollowedFlight() {
    rules.clearance_m = 0.5;
    rules.z_min_m = 0.0;
    rules.z_max_m = 2.0;
  }
  Outcome step(PathFollower& follower, const Vector3& p_m, double speed_mps = 0.0) {
    estimate.T_local_body.translation() = p_m;
    estimate.v_local_mps = {0.0, speed_mps, 0.0};
    return follower.step(
        {.dt_s = dt_s, .estimate = estimate, .observation = observation, .poses = poses, .map = &world});
  }
  ClearPathConfig rules;
  double dt_s = 0.1;
  testing::CellListMap world{0.25};
  StateEstimate estimate;
  Observation observation;
  LocalPoses poses;
};

const std::vector<Vector3> kCorners = {{0, 0, 1}, {4, 0, 1}, {4, 4, 1}, {0, 4, 1}};

TEST(PathFollower, AdvancesOnceACornerIsReached) {
  FollowedFlight flight;
  PathFollower follower(flight.rules, 0.4);
  follower.start(kCorners);
  EXPECT_EQ(follower.corners_local_m(), kCorners);
  EXPECT_EQ(flight.step(follower, {3.59, 0, 1}), Outcome::kFlying);
  flight.step(follower, {3.59, 0, 1});
  EXPECT_EQ(follower.target_local_m(), kCorners[1]) << "0.41 m away";
  flight.step(follower, {3.61, 0, 1});
  flight.step(follower, {3.61, 0, 1});
  EXPECT_EQ(follower.target_local_m(), kCorners[2]);
  EXPECT_EQ(follower.target_local().velocity_mps, Vector3(0, 0, 0));
}

TEST(PathFollower, ArrivesWhenHoveringNearLastCorner) {
  FollowedFlight flight;
  PathFollower follower(flight.rules, 0.4);
  follower.start({{0, 0, 1}, {4, 0, 1}});
  EXPECT_EQ(flight.step(follower, {3.69, 0, 1}), Outcome::kFlying) << "0.31 m away";
  EXPECT_EQ(flight.step(follower, {3.71, 0, 1}, 0.26), Outcome::kFlying) << "0.29 m away, above the arrival speed";
  EXPECT_EQ(flight.step(follower, {3.71, 0, 1}, 0.24), Outcome::kArrived);
  // Near a corner that is not the last one it has not arrived.
  follower.start(kCorners);
  EXPECT_EQ(flight.step(follower, kCorners[1]), Outcome::kFlying);
}

TEST(PathFollower, IsBlockedOnlyByObstaclesAhead) {
  FollowedFlight flight;
  PathFollower follower(flight.rules, 0.4);
  follower.start(kCorners);
  flight.step(follower, kCorners[1]);
  EXPECT_EQ(flight.step(follower, {4, 1, 1}), Outcome::kFlying);
  flight.world.occupy_box({1.5, -0.25, 0.5}, {2.0, 0.25, 1.5});  // on the completed leg
  EXPECT_EQ(flight.step(follower, {4, 1, 1}), Outcome::kFlying);
  flight.world.occupy_box({1.5, 3.75, 0.5}, {2.0, 4.25, 1.5});  // on the last leg
  EXPECT_EQ(flight.step(follower, {4, 1, 1}), Outcome::kBlocked);
  EXPECT_EQ(follower.target_local_m(), Vector3(4, 1, 1)) << "the target is the own position";
  EXPECT_EQ(flight.step(follower, {4, 1, 1}), Outcome::kFlying) << "asked once about each map";
  follower.start(kCorners);
  EXPECT_EQ(flight.step(follower, kCorners[0]), Outcome::kBlocked) << "a new path is checked again on the same map";
}

/// From the origin along x, half a meter a second.
SplineTrajectory along_x() {
  SplineTrajectory path;
  path.interval_s = 1.0;
  for (int i = 0; i <= 8; ++i) path.control_points_m.emplace_back(0.5 * i, 0.0, 1.0);
  return path;
}

TEST(PathFollower, TimedTargetFollowsSplineAndDerivatives) {
  FollowedFlight flight;
  PathFollower follower(flight.rules, 0.4);
  const UniformSpline spline = along_x().spline();
  follower.start({{0, 0, 1}, {4, 0, 1}}, along_x());
  for (int i = 1; i * flight.dt_s < spline.duration_s() - 0.05; ++i) {
    const auto [p_m, v_mps, a_mps2] = spline.at(i * flight.dt_s);
    ASSERT_EQ(flight.step(follower, spline.at((i - 1) * flight.dt_s).p_m), Outcome::kFlying);
    ASSERT_LT((follower.target_local_m() - p_m).norm(), 1e-9);
    ASSERT_LT((follower.target_local().velocity_mps - v_mps).norm(), 1e-9);
    ASSERT_LT((follower.target_local().acceleration_mps2 - a_mps2).norm(), 1e-9);
  }
  EXPECT_EQ(flight.step(follower, spline.at(spline.duration_s()).p_m, 0.26), Outcome::kFlying);
  EXPECT_EQ(flight.step(follower, spline.at(spline.duration_s()).p_m + Vector3(0, 0.31, 0)), Outcome::kFlying);
  EXPECT_EQ(flight.step(follower, spline.at(spline.duration_s()).p_m + Vector3(0, 0.29, 0), 0.24), Outcome::kArrived);
}

TEST(PathFollower, TimedTargetWaitsForDelayedVehicle) {
  FollowedFlight flight;
  PathFollower follower(flight.rules, 0.4);
  follower.start({{0, 0, 1}, {4, 0, 1}}, along_x());
  for (int i = 0; i < 30; ++i) flight.step(follower, i < 20 ? follower.target_local_m() : Vector3(9, 9, 9));
  flight.step(follower, follower.target_local_m());
  const Vector3 there_m = follower.target_local_m();
  flight.step(follower, there_m - Vector3(0.51, 0, 0));
  EXPECT_EQ(follower.target_local_m(), there_m);
  flight.step(follower, there_m - Vector3(0.49, 0, 0));
  EXPECT_GT(follower.target_local_m().x(), there_m.x() + 0.01);
  // Begun anew it begins from the start.
  follower.start({{0, 0, 1}, {4, 0, 1}}, along_x());
  flight.step(follower, {0, 0, 1});
  EXPECT_LT(follower.target_local_m().x(), 0.1);
}

TEST(PathFollower, TimedCheckCoversOnlyRemainingPath) {
  const auto blocked_at = [](double t_s, double x_m) {
    FollowedFlight flight;
    PathFollower follower(flight.rules, 0.4);
    follower.start({{0, 0, 1}, {4, 0, 1}}, along_x());
    flight.step(follower, {0, 0, 1});
    for (int i = 1; i < static_cast<int>(t_s / flight.dt_s); ++i) flight.step(follower, follower.target_local_m());
    flight.world.occupy_box({x_m, -0.25, 0.75}, {x_m + 0.25, 0.25, 1.25});
    return flight.step(follower, follower.target_local_m()) == Outcome::kBlocked;
  };
  EXPECT_TRUE(blocked_at(1.0, 3.25));
  EXPECT_FALSE(blocked_at(5.0, 0.25)) << "behind";
  EXPECT_TRUE(blocked_at(5.0, 3.25));
}

TEST(PathOverlay, IsASphereAtEachPoint) {
  const Overlay overlay = path_overlay("name", kCorners, 0.3F);
  EXPECT_EQ(overlay.kind, Overlay::Kind::kSpheres);
  EXPECT_EQ(overlay.name, "name");
  EXPECT_EQ(overlay.size_m, 0.3F);
  ASSERT_EQ(overlay.positions.size(), kCorners.size());
  for (std::size_t i = 0; i < kCorners.size(); ++i) EXPECT_EQ(overlay.positions[i].cast<double>(), kCorners[i]);
}

}  // namespace
}  // namespace swiftlet
