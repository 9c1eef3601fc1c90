// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/flight_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/dataset/free_space.hpp"
#include "swiftlet/core/planning/grid_search.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"
#include "swiftlet/sim/world/warehouse.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

/// A field of 40 m x 40 m with a wall across it, 8 m high, that has a gap 3 m wide at y = 10.
std::shared_ptr<const StaticScene> field_with_gap() {
  TestScene scene;
  scene.add_wall({-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0}, SurfaceClass::kGround);
  scene.add_box({-0.2F, -20, 0}, {0.2F, 8.5F, 8}, SurfaceClass::kWall);
  scene.add_box({-0.2F, 11.5F, 0}, {0.2F, 20, 8}, SurfaceClass::kWall);
  return std::make_shared<const StaticScene>(scene.scene());
}

constexpr double kRadius_m = 0.8;

FreeSpace space_of(const std::shared_ptr<const StaticScene>& world) {
  return {world, {.radius_m = kRadius_m, .height_min_m = 1.0, .height_max_m = 5.0, .border_m = 2.0, .cell_m = 0.5}};
}

TEST(FreeSpace, RespectsHeightLimitsAndClearances) {
  const auto world = field_with_gap();
  const FreeSpace space = space_of(world);
  EXPECT_TRUE(space.is_free(Vector3(10, 0, 3)));
  EXPECT_FALSE(space.is_free(Vector3(10, 0, 0.9)));
  EXPECT_FALSE(space.is_free(Vector3(10, 0, 5.1)));
  EXPECT_FALSE(space.is_free(Vector3(0.9, 0, 3)));  // 0.7 m from the wall
  EXPECT_TRUE(space.is_free(Vector3(1.1, 0, 3)));
  EXPECT_FALSE(space.is_free(Vector3(18.5, 0, 3)));
  EXPECT_TRUE(space.is_free(Vector3(0, 10, 3)));  // in the gap
  EXPECT_FALSE(is_free_segment(space, Vector3(-5, 0, 3), Vector3(5, 0, 3)));
  EXPECT_TRUE(is_free_segment(space, Vector3(-5, 10, 3), Vector3(5, 10, 3)));
}

TEST(FreeSpace, HasAPathThroughTheGap) {
  const auto world = field_with_gap();
  const FreeSpace space = space_of(world);
  const Vector3 from(-10, -10, 3), to(10, -10, 3);
  const std::vector<Vector3> path = find_path(space, from, to).corners_world_m;
  ASSERT_GE(path.size(), 3U);
  EXPECT_EQ(path.front(), from);
  EXPECT_EQ(path.back(), to);
  double length_m = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    length_m += (path[i] - path[i - 1]).norm();
    EXPECT_TRUE(space.is_free(path[i])) << path[i].transpose();
  }
  // The shortest path bends around the corner of the wall at (0, 8.5 + 0.8): 2 hypot(10, 19.3) = 43.5 m.
  EXPECT_GE(length_m, 43.4);
  EXPECT_LE(length_m, 46.5);
  EXPECT_TRUE(
      std::any_of(path.begin(), path.end(), [](const Vector3& p) { return std::abs(p.x()) < 3.0 && p.y() > 8.0; }));
}

TEST(FreeSpace, HasNoPathThroughAWall) {
  TestScene scene;
  scene.add_wall({-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0}, SurfaceClass::kGround);
  scene.add_box({-0.2F, -20, 0}, {0.2F, 20, 8}, SurfaceClass::kWall);
  const FreeSpace space = space_of(std::make_shared<const StaticScene>(scene.scene()));
  EXPECT_TRUE(find_path(space, {-10, 0, 3}, {10, 0, 3}).corners_world_m.empty());
  EXPECT_TRUE(find_path(space, {-10, 0, 3}, {0, 0, 3}).corners_world_m.empty());
}

TEST(FreeSpace, IndoorsAllowsForAnOpenDoor) {
  TestScene scene;
  scene.add_wall({-30, -30, 0}, {30, -30, 0}, {30, 30, 0}, {-30, 30, 0}, SurfaceClass::kGround);
  // A hall of 20 m x 20 m without a roof, 6 m high; its door of 2 m looks east.
  scene.add_box({-10.2F, -10.2F, 0}, {10.2F, -10, 6}, SurfaceClass::kWall);
  scene.add_box({-10.2F, 10, 0}, {10.2F, 10.2F, 6}, SurfaceClass::kWall);
  scene.add_box({-10.2F, -10, 0}, {-10, 10, 6}, SurfaceClass::kWall);
  scene.add_box({10, -10, 0}, {10.2F, -1, 6}, SurfaceClass::kWall);
  scene.add_box({10, 1, 0}, {10.2F, 10, 6}, SurfaceClass::kWall);
  const auto world = std::make_shared<const StaticScene>(scene.scene());
  const FreeSpace space(world, {.radius_m = kRadius_m, .height_max_m = 9.0, .indoors = true});
  EXPECT_TRUE(space.is_free(Vector3(0, 0, 3)));
  EXPECT_TRUE(space.is_free(Vector3(8, 0, 3)));  // in front of the door
  EXPECT_TRUE(space.is_free(Vector3(-9, 9, 3)));
  EXPECT_FALSE(space.is_free(Vector3(0, 0, 7)));  // above the walls
  for (const Vector3& outside : {Vector3(14, 0, 3), Vector3(0, 14, 3), Vector3(-14, -14, 3), Vector3(12, 20, 3)}) {
    EXPECT_FALSE(space.is_free(outside)) << outside.transpose();
    EXPECT_TRUE(find_path(space, {0, 0, 3}, outside).corners_world_m.empty());
    EXPECT_TRUE(space_of(world).is_free(outside));  // without restriction to the indoor space
  }
}

TEST(FreeSpace, GroundIsBelowRoofsOrAbsent) {
  TestScene scene;
  scene.add_wall({-20, -20, 1}, {20, -20, 1}, {20, 20, 1}, {-20, 20, 1}, SurfaceClass::kGround);
  scene.add_wall({-5, -5, 6}, {5, -5, 6}, {5, 5, 6}, {-5, 5, 6}, SurfaceClass::kCeiling);
  scene.add_wall({-5, -5, 8}, {5, -5, 8}, {5, 5, 8}, {-5, 5, 8}, SurfaceClass::kVegetation);
  scene.add_wall({20, -20, 0}, {30, -20, 0}, {30, 20, 0}, {20, 20, 0}, SurfaceClass::kWall);
  const FreeSpace space = space_of(std::make_shared<const StaticScene>(scene.scene()));
  EXPECT_NEAR(space.ground_m(0, 0).value(), 1.0, 2e-3);
  EXPECT_NEAR(space.ground_m(10, 0).value(), 1.0, 1e-6);
  EXPECT_FALSE(space.ground_m(25, 0).has_value());
  EXPECT_FALSE(space.is_free(Vector3(25, 0, 3)));
  EXPECT_TRUE(space.is_free(Vector3(10, 0, 3)));
  EXPECT_TRUE(space.is_free(Vector3(0, 0, 3.5)));
  // 1 to 5 m above the ground, which lies at 1 m.
  EXPECT_FALSE(space.is_free(Vector3(10, 0, 1.99)));
  EXPECT_TRUE(space.is_free(Vector3(10, 0, 2.01)));
  EXPECT_TRUE(space.is_free(Vector3(10, 0, 5.99)));
  EXPECT_FALSE(space.is_free(Vector3(10, 0, 6.01)));
}

TEST(FreeSpace, GridSamplesVolumeAtCellCenters) {
  const auto world = field_with_gap();
  const FreeSpace space(world,
                        {.radius_m = 0.8, .height_min_m = 1.0, .height_max_m = 5.0, .border_m = 2.0, .cell_m = 2.5});
  EXPECT_LT((space.area_m().min() - Eigen::Vector2d(-18, -18)).norm(), 1e-9);
  EXPECT_LT((space.area_m().max() - Eigen::Vector2d(18, 18)).norm(), 1e-9);
  const CellGrid& grid = space.grid();
  // 36 m along each side, and 5 m above the highest thing of 8 m.
  EXPECT_EQ(grid.size, Eigen::Vector3i(15, 15, 6));
  EXPECT_LT((grid.origin_world_m - Vector3(-18, -18, 0)).norm(), 1e-9);
  int free = 0;
  for (int index = 0; index < static_cast<int>(grid.num_cells()); ++index) {
    const Vector3 p = grid.center_of(index);
    const bool inside = std::abs(p.x()) <= 18.0 && std::abs(p.y()) <= 18.0 && p.z() >= 1.0 && p.z() <= 5.0;
    const bool expected = inside && !world->nearest(p, 0.8).has_value();
    EXPECT_EQ(space.is_free_cell(index), expected) << p.transpose();
    free += expected ? 1 : 0;
  }
  EXPECT_GT(free, 100);
  EXPECT_THROW(FreeSpace(world, {.cell_m = 0.01}), std::invalid_argument);
  const FreeSpace none(world, {.border_m = 20.5});
  EXPECT_TRUE(none.area_m().isEmpty());
}

/// A ring of 20 m x 20 m and 6 m high, on ground of 60 m x 60 m.
TestScene ring_of(SurfaceClass surface_class) {
  TestScene scene;
  scene.add_wall({-30, -30, 0}, {30, -30, 0}, {30, 30, 0}, {-30, 30, 0}, SurfaceClass::kGround);
  scene.add_box({-10.2F, -10.2F, 0}, {10.2F, -10, 6}, surface_class);
  scene.add_box({-10.2F, 10, 0}, {10.2F, 10.2F, 6}, surface_class);
  scene.add_box({-10.2F, -10, 0}, {-10, 10, 6}, surface_class);
  scene.add_box({10, -10, 0}, {10.2F, 10, 6}, surface_class);
  return scene;
}

bool stays_indoors(const StaticScene& world) { return stays_indoors(FlightConfig(), world); }

TEST(Interior, IsGroundEnclosedByAnyWalls) {
  for (const SurfaceClass walls :
       {SurfaceClass::kWall, SurfaceClass::kBuilding, SurfaceClass::kUnlabeled, SurfaceClass::kRack}) {
    TestScene scene = ring_of(walls);
    scene.add_box({2, 2, 0}, {4, 4, 8}, SurfaceClass::kTrunk);  // views pass plants
    const StaticScene world(scene.scene());
    EXPECT_NEAR(enclosed_share(world, 2.0), 1.0 / 9.0, 1e-9);
    EXPECT_EQ(enclosed_share(world, 7.0), 0.0) << "above the walls";
    EXPECT_TRUE(stays_indoors(world));
  }
}

TEST(Interior, GroundAndPlantsEncloseNothing) {
  for (const SurfaceClass hedge : {SurfaceClass::kGround, SurfaceClass::kVegetation, SurfaceClass::kUndergrowth,
                                   SurfaceClass::kTrunk, SurfaceClass::kBranch, SurfaceClass::kFallenTrunk}) {
    const StaticScene world(ring_of(hedge).scene());
    EXPECT_FALSE(is_enclosed(world, {0, 0, 2})) << name_of(hedge);
    EXPECT_FALSE(stays_indoors(world)) << name_of(hedge);
  }
  for (const char* type : {"forest", "field", "empty"}) {
    EXPECT_EQ(enclosed_share(StaticScene(make_world(Module(world_module_types(), type), 1)), 2.0), 0.0) << type;
  }
}

TEST(Interior, ExcludesOneBuildingOfACampus) {
  const StaticScene campus(make_world(Module(world_module_types(), "campus"), 1));
  EXPECT_GT(enclosed_share(campus, 1.5), 0.0);
  EXPECT_FALSE(stays_indoors(campus));
}

TEST(Interior, IncludesHallsRoomsAndImportedCourtyards) {
  for (const char* name : {"warehouse", "hall", "gap", "import_mesh"}) {
    const Scenario scenario = load_scenario(SWIFTLET_SOURCE_DIR "/scenarios/" + std::string(name) + ".yaml");
    EXPECT_TRUE(stays_indoors(StaticScene(make_world(scenario.world, 1)))) << name;
  }
}

/// Greatest distance of a planned position beyond the inner walls of a warehouse [m].
double beyond_walls_m(const WarehouseConfig& warehouse, const std::vector<SplineTrajectory>& paths, double duration_s) {
  double beyond_m = -1e9;
  for (const SplineTrajectory& path : paths) {
    for (double t_s = 0.0; t_s <= duration_s; t_s += 0.05) {
      const Vector3 p = path.spline().at(t_s).p_m;
      beyond_m = std::max(beyond_m, (p.head<2>().cwiseAbs() - 0.5 * warehouse.size_m.head<2>()).maxCoeff());
      beyond_m = std::max(beyond_m, p.z() - warehouse.size_m.z());
    }
  }
  return beyond_m;
}

TEST(FlightPlan, StaysInsideTheWarehouseByDefault) {
  constexpr double kDuration_s = 10.0;
  FlightConfig as_it_is, outside, inside;
  outside.indoors = FlightConfig::Indoors::kFalse;
  inside.indoors = FlightConfig::Indoors::kTrue;
  for (FlightConfig* config : {&as_it_is, &outside, &inside}) config->height_max_m = 12.0;  // higher than the walls
  for (const bool roof : {true, false}) {
    WarehouseConfig warehouse;
    warehouse.size_m = {32, 20, 8};
    warehouse.roof = roof;
    const auto world = std::make_shared<const StaticScene>(make_warehouse(warehouse, 1));
    int flown_outside = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const auto paths = plan_flight(as_it_is, world, {0.4, 0.3}, kDuration_s, seed, 0);
      ASSERT_TRUE(paths.has_value());
      EXPECT_LT(beyond_walls_m(warehouse, *paths, kDuration_s), 0.0);
      const auto same = plan_flight(inside, world, {0.4, 0.3}, kDuration_s, seed, 0);
      ASSERT_TRUE(same.has_value());
      for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ((*same)[i].control_points_m, (*paths)[i].control_points_m);
      const auto free = plan_flight(outside, world, {0.4, 0.3}, kDuration_s, seed, 0);
      if (free && beyond_walls_m(warehouse, *free, kDuration_s) > 1.0) ++flown_outside;
    }
    EXPECT_GT(flown_outside, 0);
  }
}

TEST(FlightPlan, FliesEverywhereWithoutEnclosingWalls) {
  TestScene hedges = ring_of(SurfaceClass::kVegetation);
  FlightConfig as_it_is, outside;
  outside.indoors = FlightConfig::Indoors::kFalse;
  for (const auto& world : {std::make_shared<const StaticScene>(hedges.scene()), field_with_gap()}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const auto paths = plan_flight(as_it_is, world, {0.4}, 10.0, seed, 0);
      const auto same = plan_flight(outside, world, {0.4}, 10.0, seed, 0);
      ASSERT_TRUE(paths && same);
      EXPECT_EQ(paths->front().control_points_m, same->front().control_points_m);
    }
  }
}

TEST(FlightPlan, PathsLastTheFlight) {
  TestScene scene;
  scene.add_wall({-40, -40, 0}, {40, -40, 0}, {40, 40, 0}, {-40, 40, 0}, SurfaceClass::kGround);
  const auto world = std::make_shared<const StaticScene>(scene.scene());
  FlightConfig config;
  config.leg_max_m = 20.0;
  for (const double duration_s : {3.0, 10.0}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const auto paths = plan_flight(config, world, {0.4}, duration_s, seed, 0);
      ASSERT_TRUE(paths.has_value());
      const SplineTrajectory& path = paths->front();
      EXPECT_GE(path.spline().duration_s(), duration_s);
      EXPECT_GT(path.spline().at(duration_s - 0.2).v_mps.norm(), 0.0) << "the vehicle flies until the end";
      double fastest_mps = 0.0;
      for (double t_s = 0.0; t_s < duration_s; t_s += 0.05) {
        const auto state = path.spline().at(t_s);
        EXPECT_GE(state.p_m.z(), config.height_min_m - 0.3);
        EXPECT_LE(state.p_m.z(), config.height_max_m + 0.3);
        EXPECT_LE(state.p_m.head<2>().cwiseAbs().maxCoeff(), 40.0 - config.border_m + 0.3);
        fastest_mps = std::max(fastest_mps, state.v_mps.head<2>().norm());
      }
      EXPECT_LE(fastest_mps, config.speed_max_mps + 0.05);
      EXPECT_GE(fastest_mps, 0.5 * config.speed_min_mps);
    }
  }
}

// Corners of short legs are rounded off most, and long legs are flown at cruise speed.
TEST(FlightPlan, AnyLegsLastTheFlight) {
  TestScene scene;
  scene.add_wall({-200, -200, 0}, {200, -200, 0}, {200, 200, 0}, {-200, 200, 0}, SurfaceClass::kGround);
  const auto world = std::make_shared<const StaticScene>(scene.scene());
  FlightConfig slow, fast;
  slow.speed_min_mps = slow.speed_max_mps = 0.5;
  slow.leg_min_m = 1.0;
  slow.leg_max_m = 1.5;
  fast.speed_min_mps = fast.speed_max_mps = 3.0;
  fast.leg_min_m = fast.leg_max_m = 60.0;
  for (const FlightConfig& config : {slow, fast}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const auto paths = plan_flight(config, world, {0.4, 0.3}, 40.0, seed, 0);
      ASSERT_TRUE(paths.has_value()) << seed;
      for (const SplineTrajectory& path : *paths) {
        EXPECT_GE(path.spline().duration_s(), 40.0);
        EXPECT_GT((path.spline().at(40.0).p_m - path.spline().at(39.0).p_m).norm(), 1e-3);
      }
    }
  }
}

TEST(FlightPlan, FindsNoPathWithoutFreeSpace) {
  const auto world = field_with_gap();
  FlightConfig config;
  EXPECT_FALSE(plan_flight(config, world, {25.0}, 5.0, 1, 0).has_value()) << "as large as the field";
  config.border_m = 21.0;
  EXPECT_FALSE(plan_flight(config, world, {0.4}, 5.0, 1, 0).has_value());
}

TEST(FlightPlan, TeamsComeNearWithoutCollisions) {
  const auto world = field_with_gap();
  FlightConfig config;
  config.height_max_m = 5.0;
  config.leg_max_m = 20.0;
  config.partner_max_m = 15.0;
  const std::vector<double> radii_m = {0.4, 0.3, 0.3};
  constexpr double kDuration_s = 15.0;
  double nearest_of_all_m = 1e9;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto paths = plan_flight(config, world, radii_m, kDuration_s, seed, 0);
    ASSERT_TRUE(paths.has_value());
    ASSERT_EQ(paths->size(), 3U);
    for (double t_s = 0.0; t_s <= kDuration_s; t_s += 0.02) {
      for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 p = (*paths)[i].spline().at(t_s).p_m;
        const auto surface = world->nearest(p, 10.0);
        const double clearance_m = (surface ? surface->distance_m : 10.0) - radii_m[i];
        EXPECT_GE(clearance_m, 0.5 * config.margin_m - 0.05) << "vehicle " << i << " at " << t_s;
        for (std::size_t j = 0; j < i; ++j) {
          const double distance_m = (p - (*paths)[j].spline().at(t_s).p_m).norm();
          EXPECT_GE(distance_m, config.separation_m - 1e-3);
          nearest_of_all_m = std::min(nearest_of_all_m, distance_m);
        }
      }
    }
    const auto again = plan_flight(config, world, radii_m, kDuration_s, seed, 0);
    ASSERT_TRUE(again.has_value());
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ((*again)[i].control_points_m, (*paths)[i].control_points_m);
    const auto other = plan_flight(config, world, radii_m, kDuration_s, seed, 1);
    ASSERT_TRUE(other.has_value());
    EXPECT_NE((*other)[0].control_points_m, (*paths)[0].control_points_m);
  }
  EXPECT_LT(nearest_of_all_m, 6.0);
}

}  // namespace
}  // namespace swiftlet::sim
