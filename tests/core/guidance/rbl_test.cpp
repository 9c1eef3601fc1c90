// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/guidance/flocking/rbl_cell.hpp"
#include "core/guidance/flocking/rbl_planner.hpp"
#include "core/guidance/flocking/rbl_rules.hpp"
#include "swiftlet/core/control/reference_governor.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// Volume and centroid of the part of a ball that lies below a plane at height h (closed form of the spherical cap).
struct BallPart {
  double volume, centroid;
};
BallPart below_plane(double r, double h) {
  const double volume = kPi * (2.0 * r * r * r / 3.0 + r * r * h - h * h * h / 3.0);
  const double moment = -kPi / 4.0 * (r * r - h * h) * (r * r - h * h);
  return {volume, moment / volume};
}

TEST(RblCell, SamplesFillBallAndDisc) {
  const double r = 3.5;
  for (const double step : {0.1, 0.2}) {
    const RblCell ball(r, step, false);
    EXPECT_NEAR(ball.num_samples() * step * step * step, 4.0 / 3.0 * kPi * r * r * r, 0.01 * 180.0);
    const RblCell disc(r, step, true);
    EXPECT_NEAR(disc.num_samples() * step * step, kPi * r * r, 0.02 * 38.5);
  }
}

TEST(RblCell, HalfSpaceLeavesTheSphericalCap) {
  const double r = 3.5, step = 0.1;
  RblCell cell(r, step, false);
  for (const Vector3& n : {Vector3(1, 0, 0), Vector3(0, 0, -1), Vector3(1, -2, 0.5), Vector3(-0.3, 0.2, 1)}) {
    for (const double h : {-1.93, 0.03, 1.0, 2.51}) {
      cell.reset(Vector3::Zero(), -r, r);
      cell.cut({n.normalized(), h});
      const BallPart exact = below_plane(r, h);
      EXPECT_NEAR(cell.num_partitioned() * step * step * step / exact.volume, 1.0, 0.04)
          << n.transpose() << " at " << h;
      // A weight that is nearly constant gives the centroid of the body itself.
      const Vector3 c = cell.partitioned_centroid(Vector3::Zero(), 1e5);
      EXPECT_NEAR((c - exact.centroid * n.normalized()).norm(), 0.0, 0.5 * step) << n.transpose() << " at " << h;
    }
  }
}

// A far destination weighs a ball with exp(x / beta): the centroid is r (coth k - 3 (k coth k - 1) / k^2 ...) in closed
// form, with k = r / beta: the derivative of the logarithm of (k cosh k - sinh k) / k^3.
TEST(RblCell, FarDestinationMatchesTheExponentialBall) {
  const double r = 3.5, beta = 1.5, k = r / beta;
  const double exact =
      r * (k * k * std::sinh(k) - 3.0 * (k * std::cosh(k) - std::sinh(k))) / (k * (k * std::cosh(k) - std::sinh(k)));
  RblCell cell(r, 0.1, false);
  const Vector3 direction = Vector3(1, 2, -0.5).normalized();
  EXPECT_NEAR((cell.partitioned_centroid(1e4 * direction, beta) - exact * direction).norm(), 0.0, 0.02);
}

using Cut = RblCellConfig::Cut;

TEST(NeighborCut, IsContinuousAndKeepsEncumbrancesFree) {
  const double Delta = 1.0;
  for (const double d : {2.0, 2.5, 3.0, 5.0}) {
    const HalfSpace cut = neighbor_cut({0, d, 0}, Delta, 0.9, Cut::kProgram);
    EXPECT_NEAR(cut.normal_local.y(), 1.0, 1e-12);
    EXPECT_NEAR(cut.offset_m, 1.0 + 0.9 * (d - 2.0), 1e-12);
    EXPECT_LE(cut.offset_m, d - Delta + 1e-12);
  }
  EXPECT_NEAR(neighbor_cut({2.0 + 1e-9, 0, 0}, Delta, 0.9, Cut::kProgram).offset_m,
              neighbor_cut({2.0 - 1e-9, 0, 0}, Delta, 0.9, Cut::kProgram).offset_m, 1e-6);
  // With eta = 0.5 the plane of equation (2.3) is the bisector.
  EXPECT_NEAR(neighbor_cut({4, 0, 0}, Delta, 0.5, Cut::kProgram).offset_m, 2.0, 1e-12);
}

TEST(NeighborCut, ContinuedPlaneFreesOnlyDistantEncumbrances) {
  for (const double d : {0.7, 1.5, 2.0, 4.0}) {
    const double offset_m = neighbor_cut({d, 0, 0}, 1.0, 0.9, Cut::kContinued).offset_m;
    EXPECT_NEAR(offset_m, 1.0 + 0.9 * (d - 2.0), 1e-12);
    EXPECT_EQ(d - offset_m >= 1.0 - 1e-12, d >= 2.0) << d;
  }
}

TEST(NeighborCut, ExcludesTheAgentFromCrowdedCells) {
  for (const Cut cut : {Cut::kProgram, Cut::kBuffered}) {
    EXPECT_LT(neighbor_cut({0.8, 0, 0}, 1.0, 0.9, cut).offset_m, 0.0) << static_cast<int>(cut);
  }
}

TEST(RblPlanner, IsIndependentOfNeighborOrder) {
  std::vector<Vector3> others = {{2, 1, 0}, {-1, 2, 1}, {0.5, -2, -0.3}, {1.1, 1.9, -1.5}};
  RblPlanner a({}, {}, false), b({}, {}, false);
  a.partition(Vector3::Zero(), others, 1.0 - 5.0, 5.0);
  const Vector3 c_a = a.update({20, 0, 0}, 0.1).centroid_local_m;
  std::reverse(others.begin(), others.end());
  b.partition(Vector3::Zero(), others, 1.0 - 5.0, 5.0);
  EXPECT_EQ(c_a, b.update({20, 0, 0}, 0.1).centroid_local_m);
}

TEST(RblPlanner, ReachesTheGoalAndStaysThere) {
  RblPlanner planner({}, {}, false);
  const Vector3 goal(1, 2, 5);
  planner.partition(goal, {}, 1.0, 10.0);
  EXPECT_NEAR((planner.update(goal, 0.1).centroid_local_m - goal).norm(), 0.0, 1e-3);
  planner.partition({0, 2, 5}, {}, 1.0, 10.0);
  const Vector3 c = planner.update(goal, 0.1).centroid_local_m;
  EXPECT_GT(c.x(), 0.3);
  EXPECT_LT(c.x(), 1.0);
}

TEST(RblPlanner, ClippedCellStaysBetweenTheHeights) {
  RblPlanner planner({}, {}, false);
  planner.partition({0, 0, 2.0}, {}, 1.0, 4.0);
  for (int i = 0; i < planner.cell().num_samples(); ++i) {
    ASSERT_GE(planner.cell().point(i).z(), -1.0 - 1e-5);
    ASSERT_LE(planner.cell().point(i).z(), 2.0 + 1e-5);
  }
  planner.partition({0, 0, -20.0}, {}, 1.0, 4.0);  // far below: the highest layer is left, so that it comes back
  EXPECT_GT(planner.cell().num_samples(), 0);
  EXPECT_GT(planner.update({0, 0, 2}, 0.1).centroid_local_m.z(), -20.0);
}

TEST(RblPlanner, LeavesTheSpaceOfAnotherAgent) {
  RblPlanner planner({}, {}, false);
  planner.partition(Vector3::Zero(), std::vector<Vector3>{{0.5, 0.0, 0.0}}, -10.0, 10.0);
  EXPECT_LT(planner.update({20, 0, 0}, 0.1).centroid_local_m.x(), -0.4);
  // Surrounded: the cell is empty, and the place with the least violation is taken.
  planner.partition(Vector3::Zero(), std::vector<Vector3>{{0.4, 0, 0}, {-0.4, 0, 0}, {0, 0.4, 0}, {0, -0.4, 0}}, -10.0,
                    10.0);
  const RblPlanner::Step step = planner.update({20, 0, 0}, 0.1);
  EXPECT_TRUE(step.empty_cell);
  EXPECT_TRUE(step.centroid_local_m.allFinite());
}

RblSituation stuck() {
  RblSituation now;
  now.goal_agent_m = {10, 0, 0};
  now.partitioned_agent_m = {0.2, 0, 0};
  now.sensing_agent_m = {1.7, 0, 0};
  now.unrotated_agent_m = {0.2, 0, 0};
  return now;
}

TEST(RblRules, BetaFallsWhileStuckAndRecovers) {
  const RblRules rules;
  RblState state;
  for (int i = 0; i < 5; ++i) state = apply_rules(rules, stuck(), state, 0.1, false);
  EXPECT_NEAR(state.beta_m, 1.0, 1e-9);
  for (int i = 0; i < 50; ++i) state = apply_rules(rules, stuck(), state, 0.1, false);
  EXPECT_NEAR(state.beta_m, rules.beta_min_m, 1e-9);
  RblSituation free = stuck();
  free.partitioned_agent_m = free.sensing_agent_m;
  const double before = state.beta_m;
  state = apply_rules(rules, free, state, 0.1, false);
  EXPECT_NEAR(state.beta_m, before + 0.1 * (1.5 - before), 1e-9);  // third case of (2.7)
}

TEST(RblRules, AzimuthTurnsWhileStuckAndReturns) {
  RblRules rules;
  rules.azimuth_reset = RblRules::AzimuthReset::kNone;
  RblState state;
  for (int i = 0; i < 10; ++i) state = apply_rules(rules, stuck(), state, 0.1, false);
  EXPECT_NEAR(state.theta_rad, 1.0, 1e-9);
  for (int i = 0; i < 10; ++i) state = apply_rules(rules, stuck(), state, 0.1, false);
  EXPECT_NEAR(state.theta_rad, kPi / 2.0, 1e-9);
  RblSituation free = stuck();
  free.partitioned_agent_m = free.sensing_agent_m;
  state = apply_rules(rules, free, state, 0.1, false);
  EXPECT_NEAR(state.theta_rad, kPi / 2.0 - 0.2, 1e-9);
}

TEST(RblRules, PrintedAzimuthConditionIsTheOpposite) {
  RblRules rules;
  rules.azimuth_condition = RblRules::AzimuthCondition::kPrinted;
  EXPECT_EQ(apply_rules(rules, stuck(), {}, 0.1, false).theta_rad, 0.0);
  RblSituation now = stuck();
  now.partitioned_agent_m = {0.6, 0, 0};
  EXPECT_NEAR(apply_rules(rules, now, {}, 0.1, false).theta_rad, 0.1, 1e-9);
}

TEST(RblRules, GoesUpNorthwardsAndDownSouthwards) {
  const RblRules rules;
  RblSituation now = stuck();
  now.sensing_agent_m.z() = 0.0;
  now.goal_agent_m = {0, 10, 0};
  EXPECT_NEAR(vertical_influence(rules, now), 0.3, 1e-12);
  now.goal_agent_m = {0, -10, 0};
  EXPECT_NEAR(vertical_influence(rules, now), -0.3, 1e-12);
  now.goal_agent_m = {10, 0, 0};
  EXPECT_NEAR(vertical_influence(rules, now), 0.0, 1e-12);
  now.sensing_agent_m.z() = 1.0;  // clipped from below: up
  EXPECT_NEAR(vertical_influence(rules, now), 0.7, 1e-12);
}

TEST(RblRules, OwnTurnCountsBackwardsLimitingPhi) {
  const RblRules rules;
  RblState state;
  for (int i = 0; i < 60; ++i) {  // c_S follows the destination
    RblSituation now = stuck();
    now.goal_agent_m = {0, 10, 0};
    now.sensing_agent_m = 2.0 * rbl_destination(rules, now.goal_agent_m, state).normalized();
    state = apply_rules(rules, now, state, 0.1, false);
  }
  // Where centering and direction balance (2.18): w_1 * 2 m * sin(phi) = w_2, within a step of the rule.
  EXPECT_NEAR(state.phi_rad, std::asin(0.3 / 0.7 / 2.0), 0.11);
}

TEST(RblRules, PhiRisesToAnEighthTurn) {
  RblRules rules;
  rules.elevation_sense = RblRules::ElevationSense::kUp;
  RblSituation now = stuck();
  now.goal_agent_m = {1, 10, 0};
  ASSERT_TRUE(wants_elevation(rules, now));  // the neighbors leave 1.5 m less of the distance
  RblState state;
  for (int i = 0; i < 20; ++i) state = apply_rules(rules, now, state, 0.1, false);
  EXPECT_NEAR(state.phi_rad, kPi / 4.0, 1e-9);
  now.partitioned_agent_m = now.sensing_agent_m;
  for (int i = 0; i < 3; ++i) state = apply_rules(rules, now, state, 0.1, false);
  EXPECT_NEAR(state.phi_rad, kPi / 4.0 - 0.3, 1e-9);
  EXPECT_EQ(apply_rules(rules, now, state, 0.1, true).phi_rad, 0.0);  // 2D
}

TEST(RblRules, ElevationResetsWhereItIsUseless) {
  RblRules rules;
  rules.elevation_sense = RblRules::ElevationSense::kUp;
  RblSituation now = stuck();
  now.goal_agent_m = {1, 10, 0};
  now.partitioned_agent_m.z() = 0.1;
  RblState state;
  state.phi_rad = kPi / 4.0;
  EXPECT_EQ(apply_rules(rules, now, state, 0.1, false).phi_rad, 0.0);
}

TEST(RblRules, TurnsTheDestinationKeepingItsDistance) {
  RblRules rules;
  const Vector3 goal(10, 0, 0);
  EXPECT_NEAR((rbl_destination(rules, goal, {}) - goal).norm(), 0.0, 1e-9);
  const Vector3 right = rbl_destination(rules, goal, {1.5, kPi / 2.0, 0.0});
  EXPECT_NEAR((right - Vector3(0, -10, 0)).norm(), 0.0, 1e-9);
  const Vector3 up = rbl_destination(rules, goal, {1.5, 0.0, kPi / 4.0});
  EXPECT_NEAR((up - 10.0 * Vector3(1, 0, 1).normalized()).norm(), 0.0, 1e-9);
  rules.elevation_sense = RblRules::ElevationSense::kPrinted;  // erratum of (2.20)
  EXPECT_LT(rbl_destination(rules, goal, {1.5, 0.0, kPi / 4.0}).z(), 0.0);
  const Vector3 slanted = rbl_destination(rules, {3, -4, 12}, {1.5, 0.4, 0.2});
  EXPECT_NEAR(slanted.norm(), 13.0, 1e-9);
}

TEST(RblPlanner, EntersTheGapBetweenRestingNeighbors) {
  const auto left_m = [](double weight_goal_m) {
    RblCellConfig cells;
    cells.step_m = 0.35;
    RblRules rules;
    rules.weight_goal_m = weight_goal_m;
    RblPlanner planner(cells, rules, false);
    const std::vector<Vector3> others = {{2.09, 0, 5}, {-2.09, 0, 5}};
    const Vector3 goal(0, 0, 5);
    Vector3 p(0, 0.2, 6.4);
    for (int i = 0; i < 300; ++i) {
      planner.partition(p, others, 1.0, 10.0);
      p += 0.2 * (planner.update(goal, 0.1).centroid_local_m - p);
    }
    return (p - goal).norm();
  };
  EXPECT_LT(left_m(RblRules{}.weight_goal_m), 0.2);
  EXPECT_GT(left_m(0.0), 0.5) << "as printed";
}

/// Points that keep Table 2.1's motion limits and follow their centroids: the algorithm without a vehicle's dynamics.
struct Crossing {
  std::vector<Vector3> start, goal;
  double z_min = 1.0, z_max = 10.0;
};

struct CrossingResult {
  double least_separation_m = 1e9;
  double longest_s = 0.0;
  int arrived = 0;
  std::vector<Vector3> at_5_s;
};

CrossingResult cross(const Crossing& crossing, bool planar, double duration_s = 60.0) {
  const int n = static_cast<int>(crossing.start.size());
  RblCellConfig cells;
  cells.step_m = 0.35;
  RblRules rules;
  std::vector<RblPlanner> planners;
  std::vector<ReferenceGovernor> bodies;
  for (int i = 0; i < n; ++i) {
    planners.emplace_back(cells, rules, planar);
    bodies.emplace_back(MotionLimits{});
    Reference start;
    start.position_m = crossing.start[i];
    bodies[i].reset(start);
  }
  CrossingResult result;
  std::vector<Reference> wanted(n);
  std::vector<bool> arrived(n, false);
  const auto p = [&](int i) -> const Vector3& { return bodies[i].state().position_m; };
  for (int tick = 0; tick * 0.01 < duration_s && result.arrived < n; ++tick) {
    for (int i = 0; i < n && tick % 10 == 0; ++i) {
      std::vector<Vector3> others;
      for (int j = 0; j < n; ++j) {
        if (j != i) others.push_back(p(j));
      }
      planners[i].partition(p(i), others, crossing.z_min, crossing.z_max);
      wanted[i].position_m = planners[i].update(crossing.goal[i], 0.1).centroid_local_m;
    }
    for (int i = 0; i < n; ++i) {
      bodies[i].step(wanted[i], 0.01);
      if (arrived[i] || (p(i) - crossing.goal[i]).norm() > 0.2) continue;
      arrived[i] = true;
      ++result.arrived;
      result.longest_s = tick * 0.01;
    }
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < i; ++j) result.least_separation_m = std::min(result.least_separation_m, (p(i) - p(j)).norm());
    }
    if (tick == 500) {
      for (int i = 0; i < n; ++i) result.at_5_s.push_back(p(i));
    }
  }
  return result;
}

Crossing circle(int n, double radius, double turn = 0.0) {
  Crossing crossing;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * kPi * i / n + turn;
    crossing.start.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 5.0);
    crossing.goal.emplace_back(-crossing.start.back().x(), -crossing.start.back().y(), 5.0);
  }
  return crossing;
}

TEST(RblCrossing, TenVehiclesCrossACircleSafely) {
  for (const bool planar : {true, false}) {
    const CrossingResult result = cross(circle(10, 10.0), planar);
    EXPECT_EQ(result.arrived, 10) << planar;
    EXPECT_GT(result.least_separation_m, 1.0) << planar;
  }
}

TEST(RblCrossing, RotatingTheCircleRotatesTheFlight) {
  Crossing crossing;
  crossing.start = {{-6, 0, 5}, {6, 1, 5}, {0, 7, 5}};
  crossing.goal = {{6, 0, 5}, {-6, -1, 5}, {0, -7, 5}};
  const CrossingResult as_is = cross(crossing, true);
  const Matrix3 R = Eigen::AngleAxisd(kPi / 2.0, Vector3::UnitZ()).toRotationMatrix();  // the lattice turns into itself
  for (auto* points : {&crossing.start, &crossing.goal}) {
    for (Vector3& point : *points) point = R * point;
  }
  const CrossingResult turned = cross(crossing, true);
  ASSERT_EQ(as_is.at_5_s.size(), 3U);
  ASSERT_EQ(turned.at_5_s.size(), 3U);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR((R * as_is.at_5_s[i] - turned.at_5_s[i]).norm(), 0.0, 0.02);
}

TEST(RblCrossing, VehiclesStartingTooCloseMoveApart) {
  Crossing crossing;
  crossing.start = {{0, 0, 5}, {0.6, 0, 5}};
  crossing.goal = {{0, 8, 5}, {0.6, 8, 5}};
  const CrossingResult result = cross(crossing, false, 6.0);
  EXPECT_NEAR(result.least_separation_m, 0.6, 0.01);  // never nearer than at the start
  ASSERT_EQ(result.at_5_s.size(), 2U);
  EXPECT_GT((result.at_5_s[0] - result.at_5_s[1]).norm(), 1.0);
}

}  // namespace
}  // namespace swiftlet
