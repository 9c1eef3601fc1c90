// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "core/guidance/flocking/rbl_cell.hpp"
#include "core/guidance/flocking/rbl_planner.hpp"
#include "core/guidance/flocking/rbl_rules.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "tests/core/guidance/guidance_driver.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using testing::CellListMap;
using testing::GuidanceDriver;

/// Held up by others: c_A lies near the vehicle, c_S far ahead.
RblSituation held_up() {
  RblSituation now;
  now.goal_agent_m = {10, 0, 0};
  now.partitioned_agent_m = {0.2, 0, 0};
  now.sensing_agent_m = {1.7, 0, 0};
  now.unrotated_agent_m = {0.2, 0, 0};
  return now;
}

RblState at_right_angle() {
  RblState state;
  state.theta_rad = kPi / 2.0;
  return state;
}

TEST(RblInterpretations, ActsOnlyNearAndHeldUp) {
  const auto state = [](double reach_m, double lost_m, double goal_m = 10.0) {
    RblSituation now = held_up();
    now.goal_agent_m = {goal_m, 0, 0};
    now.partitioned_agent_m = now.unrotated_agent_m = {reach_m, 0, 0};
    now.sensing_agent_m = {reach_m + lost_m, 0, 0};
    return apply_rules({}, now, {}, 0.1, false);
  };
  EXPECT_GT(state(0.2, 1.5).theta_rad, 0.0);
  EXPECT_EQ(state(0.2, 0.2).theta_rad, 0.0) << "not held up";
  EXPECT_EQ(state(1.0, 1.5).theta_rad, 0.0) << "the centroid is far enough to make progress";
  EXPECT_LT(state(0.2, 1.5).beta_m, 1.5);
  EXPECT_EQ(state(0.2, 0.2).beta_m, 1.5);
  EXPECT_LT(state(0.2, 0.2, 2.0).beta_m, 1.5) << "the goal lies in the sensing region";
}

TEST(RblInterpretations, ResetsAzimuthByItsInterpretation) {
  using Reset = RblRules::AzimuthReset;
  RblRules rules;
  const auto is_reset = [&](Reset reset, double direct_m) {
    rules.azimuth_reset = reset;
    RblSituation now = held_up();
    now.unrotated_agent_m = {direct_m, 0, 5.0};  // horizontal lengths count
    return apply_rules(rules, now, at_right_angle(), 0.1, false).theta_rad == 0.0;
  };
  EXPECT_FALSE(is_reset(Reset::kNear, 0.4)) << "longer than the detour, but near";
  EXPECT_TRUE(is_reset(Reset::kNear, 0.8));
  EXPECT_FALSE(is_reset(Reset::kDetour, 0.1));
  EXPECT_TRUE(is_reset(Reset::kDetour, 0.4));
  EXPECT_FALSE(is_reset(Reset::kNone, 5.0));
}

TEST(RblInterpretations, RestoresBetaWithoutOvershoot) {
  RblSituation free = held_up();
  free.partitioned_agent_m = free.sensing_agent_m;
  RblState state;
  state.beta_m = 0.3;
  EXPECT_NEAR(apply_rules({}, free, state, 1.0, false).beta_m, 1.5, 1e-12);
  EXPECT_NEAR(apply_rules({}, free, state, 5.0, false).beta_m, 1.5, 1e-12);
}

TEST(RblInterpretations, ZeroesAnglesOfDisabledRules) {
  RblRules rules;
  rules.azimuth_rule = false;
  EXPECT_EQ(apply_rules(rules, held_up(), at_right_angle(), 0.1, false).theta_rad, 0.0);
  rules = {};
  rules.elevation_rule = false;
  RblState state;
  state.phi_rad = 0.5;
  EXPECT_EQ(apply_rules(rules, held_up(), state, 0.1, false).phi_rad, 0.0);
}

TEST(RblInterpretations, RequestsElevationForGapOrLoss) {
  RblRules rules;
  RblSituation now;
  const auto wants = [&](const Vector3& partitioned_m, const Vector3& sensing_m) {
    now.partitioned_agent_m = partitioned_m;
    now.sensing_agent_m = sensing_m;
    return wants_elevation(rules, now);
  };
  EXPECT_TRUE(wants({1.0, 0, 0}, {1.0, 0, 1.5})) << "gap";
  EXPECT_FALSE(wants({1.0, 0, 0.3}, {1.0, 0, 0.3}));
  EXPECT_TRUE(wants({0.6, 0, 0}, {1.0, 0, 0})) << "loss";
  EXPECT_FALSE(wants({1.4, 0, 0}, {1.0, 0, 0})) << "a gain is no loss";
  rules.elevation_condition = RblRules::ElevationCondition::kPrinted;
  EXPECT_TRUE(wants({1.0, 0, 0.1}, {1.0, 0, 0.1})) << "printed: without a gap";
  EXPECT_FALSE(wants({1.0, 0, 0.1}, {1.0, 0, 1.5}));
}

TEST(RblRules, HasNoDirectionAtTheGoal) {
  EXPECT_EQ(rbl_destination({}, Vector3::Zero(), {1.5, 0.3, 0.2}), Vector3(0, 0, 0));
  RblSituation now;
  now.goal_agent_m = {0, 0, 5};
  now.sensing_agent_m = {0, 0, 0.4};
  RblRules rules;
  rules.elevation_sense = RblRules::ElevationSense::kUp;
  for (int i = 0; i < 3; ++i) {
    rules.direction_influence = static_cast<RblRules::DirectionInfluence>(i);
    EXPECT_NEAR(vertical_influence(rules, now), rules.centering_weight * 0.4, 1e-12);
  }
}

using Variant = RblConfig::Variant;

/// The goal is where the cell sends the vehicle, not yet a reference that can stop.
RblConfig flying(Variant variant) {
  RblConfig config;
  config.separation.enabled = false;
  config.variant = variant;
  config.goal_m = {0.0, 0.0, 2.0};
  return config;
}

/// Goal of the first update.
Vector3 first_goal_m(const RblConfig& config, const Vector3& from_m, const std::vector<Vector3>& others_m = {}) {
  GuidanceDriver driver("rbl", config, from_m);
  for (std::size_t i = 0; i < others_m.size(); ++i) driver.sees(static_cast<VehicleId>(i) + 1, others_m[i]);
  driver.step();
  driver.dt_s = 0.0999;  // the goal glides until just before the next update
  return driver.step().goal.position_m;
}

TEST(RblFlight, LimitsHeightOfClippedVariantsOnly) {
  for (const Variant variant : {Variant::k3d, Variant::k3dClipped, Variant::k3dZ}) {
    RblConfig config = flying(variant);
    config.goal_m = {0.0, 0.0, 30.0};
    config.z_max_m = 10.0;
    const double up_m = first_goal_m(config, {0.0, 0.0, 9.9}).z();
    EXPECT_EQ(up_m > 10.5, variant == Variant::k3d) << static_cast<int>(variant) << ": " << up_m;
    config.goal_m = {0.0, 0.0, -30.0};
    config.z_min_m = 4.0;
    const double down_m = first_goal_m(config, {0.0, 0.0, 4.1}).z();
    EXPECT_EQ(down_m < 3.5, variant == Variant::k3d) << static_cast<int>(variant) << ": " << down_m;
  }
}

TEST(RblFlight, ProgressesWithAnUpdateEveryTick) {
  RblConfig config = flying(Variant::k3d);
  config.goal_m = {30.0, 0.0, 10.0};
  for (const double dt_s : {0.05, 0.1, 0.2}) {  // an update takes 0.1 s
    GuidanceDriver driver("rbl", config, {0.0, 0.0, 10.0});
    driver.dt_s = dt_s;
    for (int k = 0; k < 4; ++k) driver.step();
    EXPECT_GT(driver.out.goal.position_m.x(), 0.5) << dt_s;
  }
}

TEST(RblFlight, KeepsEncumbranceAboveGroundWithoutLimits) {
  RblConfig config = flying(Variant::k3d);
  config.goal_m = {0.0, 0.0, -30.0};
  config.ground_m = 5.0;
  config.rules.beta_desired_m = 0.1;
  const double down_m = first_goal_m(config, {0.0, 0.0, 6.5}).z();
  EXPECT_GT(down_m, 5.5 - 1e-6);
  EXPECT_LT(down_m, 6.0);
}

TEST(RblFlight, TurnsToNeighborsInBlindSector) {
  RblConfig config = flying(Variant::k3d);
  config.goal_m = {20.0, 0.0, 5.0};
  for (const bool separation : {true, false}) {
    config.separation.enabled = separation;
    GuidanceDriver driver("rbl", config, {0.0, 0.0, 5.0});
    NeighborView ahead;
    ahead.cones.push_back({Vector3::UnitX(), 0.0});
    driver.setup.neighbor_views = {ahead};
    driver.make("rbl", config);
    driver.sees(1, {-2.0, 0.5, 5.0});  // behind, known from an earlier turn
    bool looks_back = false;
    for (int i = 0; i < 80; ++i) {
      const Reference& reference = driver.step().goal;
      looks_back = looks_back || std::cos(reference.yaw_rad) * -2.0 + std::sin(reference.yaw_rad) * 0.5 > 0.0;
      if (separation) driver.put(reference.position_m, reference.yaw_rad);
    }
    EXPECT_EQ(looks_back, separation);
  }
}

TEST(RblFlight, PassesStandingVehicleAtSafeDistance) {
  RblConfig config = flying(Variant::k3d);
  config.separation.enabled = true;
  config.goal_m = {20.0, 0.0, 5.0};
  config.rules.beta_min_m = 0.1;
  const Vector3 other_m(3.0, 0.0, 5.0);
  for (const double beta_m : {0.1, 0.4, 1.5}) {
    for (const double radius_m : {3.5, 7.0}) {
      config.rules.beta_desired_m = beta_m;
      config.cells.sensing_radius_m = radius_m;
      GuidanceDriver driver("rbl", config, {0.0, 0.0, 5.0});
      for (int k = 0; k < 100; ++k) {
        driver.sees(1, other_m);
        driver.put(driver.step().goal.position_m);
        ASSERT_TRUE(driver.out.goal_is_feasible);
        ASSERT_GE((driver.p_m() - other_m).norm(), 1.0) << beta_m << " " << radius_m << " " << k;
      }
      EXPECT_GT(driver.p_m().x(), 3.0) << beta_m << " " << radius_m;
    }
  }
}

TEST(RblFlight, TakesGoalHeightInTheDisc) {
  RblConfig config = flying(Variant::k2d);
  config.goal_m = {10.0, 0.0, 7.0};
  GuidanceDriver driver("rbl", config, {0.0, 0.0, 2.0});
  driver.step();
  EXPECT_NEAR(first_goal_m(config, {0.0, 0.0, 2.0}).z(), 7.0, 0.01);
  // Right below its goal it has arrived in two dimensions, but not in three.
  EXPECT_EQ(GuidanceDriver("rbl", config, {10.0, 0.1, 2.0}).step().mission, MissionStatus::kDone);
  config.variant = Variant::k3d;
  EXPECT_EQ(GuidanceDriver("rbl", config, {10.0, 0.1, 2.0}).step().mission, MissionStatus::kRunning);
}

TEST(RblFlight, OnceArrivedIsArrived) {
  const RblConfig config = flying(Variant::k3d);
  GuidanceDriver driver("rbl", config, {0.0, 0.0, 2.3});
  EXPECT_EQ(driver.step().mission, MissionStatus::kRunning);
  driver.put({0.0, 0.0, 2.15});
  EXPECT_EQ(driver.step().mission, MissionStatus::kDone);
  driver.put({0.0, 3.0, 2.0});
  EXPECT_EQ(driver.step().mission, MissionStatus::kDone);
  EXPECT_EQ(driver.out.speed_limit_mps, config.speed_mps);
}

TEST(RblFlight, AnnouncesItsPlaceOncePerUpdate) {
  RblConfig config = flying(Variant::k3d);
  config.neighbors.source = NeighborSourceConfig::Source::kRadio;
  GuidanceDriver driver("rbl", config, {0.0, 0.0, 2.0});
  driver.dt_s = 0.02;
  for (int i = 0; i < 50; ++i) driver.step();
  EXPECT_EQ(driver.outbox.messages().size(), 10U);
}

RblConfig with_lidar() {
  RblConfig config = flying(Variant::k3dClipped);
  config.lidar.enabled = true;
  config.goal_m = {20.0, 0.0, 2.0};
  return config;
}

/// Goal after some updates of a vehicle that stays where it is and looks in a direction.
Vector3 goal_in_sight_m(const RblConfig& config, const std::vector<Vector3>& cells_m, double yaw_rad = 0.0,
                        const Vector3& at_m = {0.0, 0.0, 2.0}) {
  const CellListMap map(0.2, cells_m);
  GuidanceDriver driver("rbl", config, at_m, yaw_rad);
  driver.map = &map;
  driver.dt_s = 0.02;
  EXPECT_TRUE(driver.guidance->needs().map);
  for (int i = 0; i < 5; ++i) driver.step();
  return driver.out.goal.position_m;
}

TEST(RblFlight, ShortensItsStepBeforeAnObstacle) {
  const double free_m = goal_in_sight_m(with_lidar(), {}).x();
  EXPECT_GT(free_m, 1.0);
  std::vector<Vector3> wall_m;
  for (int y = -20; y <= 20; ++y) {
    for (int z = 0; z < 30; ++z) wall_m.emplace_back(1.6, 0.2 * y, 0.1 + 0.2 * z);
  }
  const double before_m = goal_in_sight_m(with_lidar(), wall_m).x();
  EXPECT_LT(before_m, 1.5 - 0.5) << "the encumbrance before the wall stays free";
  EXPECT_LT(before_m, free_m - 0.3);
}

TEST(RblFlight, IgnoresGroundFarBelowLowestLevel) {
  RblConfig config = with_lidar();
  config.z_min_m = 1.5;
  std::vector<Vector3> ground_m, higher_m;
  for (int x = -20; x <= 20; ++x) {
    for (int y = -20; y <= 20; ++y) {
      ground_m.emplace_back(0.2 * x, 0.2 * y, 0.85);  // its top is 0.55 m below the level: deeper than the encumbrance
      higher_m.emplace_back(0.2 * x, 0.2 * y, 1.35);
    }
  }
  EXPECT_EQ(goal_in_sight_m(config, ground_m), goal_in_sight_m(config, {}));
  EXPECT_NE(goal_in_sight_m(config, higher_m), goal_in_sight_m(config, {}));
}

TEST(RblFlight, TurnsToTheCentroidBeforeMoving) {
  RblConfig config = with_lidar();
  const CellListMap map(0.2);
  GuidanceDriver driver("rbl", config, {0.0, 0.0, 2.0}, 1.5);
  driver.map = &map;
  driver.dt_s = 0.02;
  for (int i = 0; i < 8; ++i) driver.step();
  EXPECT_NEAR(driver.out.goal.yaw_rad, 0.0, 0.05) << "along +x";
  EXPECT_LT((driver.out.goal.position_m - driver.p_m()).norm(), 1e-9) << "the vehicle turns before it moves";
  driver.put({0.0, 0.0, 2.0}, 1.0);  // 57 degrees: within facing_deg
  for (int i = 0; i < 8; ++i) driver.step();
  EXPECT_GT((driver.out.goal.position_m - driver.p_m()).norm(), 0.3);
}

// The centroid lies above what the sensor sees. The nearest place in view takes it nearer to a neighbor's plane.
TEST(RblFlight, CutsWholeLegalCellByNeighbors) {
  const Vector3 other_m(1.8, 0.0, 3.0), from_m(0.0, 0.0, 2.0);
  const auto beyond_m = [&](RblLidarConfig::Legal legal) {
    RblConfig config = with_lidar();
    config.goal_m = {3.0, 0.0, 9.0};
    config.lidar.legal = legal;
    config.separation.enabled = false;  // the cell alone keeps them apart
    config.lidar.facing_deg = 180.0;    // may fly in any direction, wherever it looks
    const CellListMap map(0.2);
    GuidanceDriver driver("rbl", config, from_m);
    driver.map = &map;
    driver.dt_s = 0.02;
    for (int i = 0; i < 5; ++i) {
      driver.sees(1, other_m);
      driver.step();
    }
    const HalfSpace cut =
        neighbor_cut(other_m - from_m, 2.0 * config.cells.encumbrance_m, config.cells.eta, config.cells.cut);
    return cut.normal_local.dot(driver.out.goal.position_m - from_m) - cut.offset_m;
  };
  EXPECT_LT(beyond_m(RblLidarConfig::Legal::kCell), 0.01);
  EXPECT_GT(beyond_m(RblLidarConfig::Legal::kSensed), beyond_m(RblLidarConfig::Legal::kCell) + 0.01);
}

TEST(RblFlight, FliesUnseenToGoalsWithinEncumbrance) {
  RblConfig config = with_lidar();
  config.goal_m = {0.0, 0.0, 2.45};  // right above, where the sensor never looks
  EXPECT_GT(goal_in_sight_m(config, {}).z(), 2.1);
}

TEST(RblFlight, LimitsHeightInTheWorldFrame) {
  RblConfig config = flying(Variant::k3dClipped);
  config.goal_m = {0.0, 0.0, 90.0};
  config.z_max_m = 10.0;
  const Vector3 origin_m(3.0, 0.0, 5.0);  // origin of the local frame
  GuidanceDriver driver("rbl", config, {0.0, 0.0, 4.9});
  driver.estimate.correct(make_pose(origin_m, Eigen::Quaterniond::Identity()));
  driver.step();
  driver.dt_s = 0.0999;
  const Vector3 goal_m = driver.step().goal.position_m;
  EXPECT_LT((goal_m + origin_m - first_goal_m(config, {3.0, 0.0, 9.9})).norm(), 1e-6);
}

const Overlay* named(const std::vector<Overlay>& overlays, const std::string& name) {
  for (const Overlay& overlay : overlays) {
    if (overlay.name == name) return &overlay;
  }
  return nullptr;
}

// One neighbor ahead cuts a straight side off the circle: every corner lies on the circle or on the plane.
TEST(RblFlight, OutlinesTheCircleCutByPlanes) {
  RblConfig config = flying(Variant::k3d);
  config.separation.enabled = false;
  const Vector3 p_m(1.0, 2.0, 5.0);
  GuidanceDriver driver("rbl", config, p_m);
  driver.sees(1, p_m + Vector3(3.0, 0.0, 0.0));
  driver.step();
  std::vector<Overlay> overlays;
  driver.guidance->append_overlays(overlays);
  const Overlay* outline = named(overlays, "rbl.cell_outline");
  ASSERT_NE(outline, nullptr);
  const double plane_m = neighbor_cut({3.0, 0.0, 0.0}, 1.0, config.cells.eta, config.cells.cut).offset_m;
  int on_plane = 0;
  for (std::size_t i = 1; i < outline->positions.size(); ++i) {  // the last is the first
    const Vector3 q = outline->positions[i].cast<double>() - p_m;
    ASSERT_NEAR(q.z(), 0.0, 1e-5);
    ASSERT_LE(q.x(), plane_m + 1e-5);
    const bool on = std::abs(q.x() - plane_m) < 1e-5;
    on_plane += on ? 1 : 0;
    if (!on) {
      ASSERT_NEAR(q.norm(), config.cells.sensing_radius_m, 1e-5);
    }
  }
  EXPECT_EQ(on_plane, 2);
  EXPECT_EQ(outline->positions.front(), outline->positions.back());
  const double r = config.cells.sensing_radius_m,
               cut_off = r * r * std::acos(plane_m / r) - plane_m * std::sqrt(r * r - plane_m * plane_m);
  const Overlay* triangles = named(overlays, "rbl.cell");
  ASSERT_NE(triangles, nullptr);
  double filled_m2 = 0.0;
  for (std::size_t i = 0; i + 2 < triangles->positions.size(); i += 3) {
    const auto& at = triangles->positions;
    filled_m2 += 0.5 * (at[i + 1] - at[i]).cross(at[i + 2] - at[i]).norm();
  }
  EXPECT_NEAR(filled_m2, kPi * r * r - cut_off, 0.02 * filled_m2);
}

TEST(RblFlight, ShowsItsCellGoalAndObstacles) {
  RblConfig config = with_lidar();
  GuidanceDriver driver("rbl", config, {0.0, 0.0, 2.0});
  const CellListMap map(0.2, {{2.0, 1.0, 2.1}, {-40.0, 0.0, 2.0}});
  driver.map = &map;
  driver.sees(1, {3.0, 0.0, 2.0});
  driver.step();
  std::vector<Overlay> overlays;
  driver.guidance->append_overlays(overlays);
  EXPECT_EQ(overlays.size(), 9U);
  for (const Overlay& overlay : overlays) EXPECT_FALSE(overlay.positions.empty()) << overlay.name;
  EXPECT_EQ(named(overlays, "rbl.goal")->positions.at(0), config.goal_m.cast<float>());
  EXPECT_EQ(named(overlays, "rbl.voxels")->positions.size(), 1U) << "near ones only";
}

/// Length of the cell ahead with a hovering neighbor ahead.
double reach_to_neighbor_m(RblConfig config, const Vector3& variance_m2, double ahead_m = 3.0) {
  const Vector3 p_m(1.0, 2.0, 5.0);
  config.separation.enabled = true;
  config.separation.pledge_share = 0.0;  // the pledge takes a share of the room until the next sample
  config.goal_m = p_m;                   // at rest
  GuidanceDriver driver("rbl", config, p_m);
  for (int i = 0; i < 40; ++i) {
    driver.sees(1, p_m + Vector3(ahead_m, 0.0, 0.0));
    driver.observation.neighbors.back().covariance_body = variance_m2.asDiagonal();
    driver.step();
  }
  std::vector<Overlay> overlays;
  driver.guidance->append_overlays(overlays);
  double reach_m = 0.0;
  for (const Eigen::Vector3f& q : named(overlays, "rbl.cell_outline")->positions)
    reach_m = std::max(reach_m, static_cast<double>(q.x()) - p_m.x());
  return reach_m;
}

// Two that rest share the room between them, less both encumbrances and the margin.
TEST(RblFlight, KeepsTheMarginBesideTheEncumbrances) {
  RblConfig config = flying(Variant::k3d);
  config.separation.sigmas = 0.0;
  for (const double margin_m : {0.0, 0.1, 0.6}) {
    config.separation.margin_m = margin_m;
    EXPECT_NEAR(reach_to_neighbor_m(config, Vector3::Constant(1e-8)),
                0.5 * (3.0 - 2.0 * config.cells.encumbrance_m - margin_m), 1e-3);
  }
}

TEST(RblFlight, ShrinksOnlyForUncertaintyTowardsNeighbors) {
  const RblConfig config = flying(Variant::k3d);
  const double sure_m = reach_to_neighbor_m(config, Vector3::Constant(1e-6), 4.5);
  EXPECT_NEAR(reach_to_neighbor_m(config, {1e-6, 0.09, 0.09}, 4.5), sure_m, 1e-3);
  EXPECT_LT(reach_to_neighbor_m(config, {0.09, 1e-6, 1e-6}, 4.5), sure_m - 0.03);
}

TEST(RblInterpretations, AlignsWorldLatticeToStepMultiples) {
  RblCellConfig config;
  config.lattice = RblCellConfig::Lattice::kWorld;
  RblPlanner planner(config, RblRules{}, false);
  for (const Vector3& p_m : {Vector3(0.07, -3.33, 5.18), Vector3(-12.11, 0.05, 4.71)}) {
    planner.partition(p_m, {}, -100.0, 100.0);
    for (int i = 0; i < planner.cell().num_samples(); ++i) {
      const Vector3 cells = (p_m + planner.cell().point(i)) / config.step_m;
      ASSERT_LT((cells - cells.array().round().matrix()).norm(), 1e-4);
      ASSERT_LE(planner.cell().point(i).norm(), config.sensing_radius_m + 1e-5);
    }
  }
}

}  // namespace
}  // namespace swiftlet
