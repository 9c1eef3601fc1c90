// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <numbers>

#include "swiftlet/sim/world/campus.hpp"
#include "swiftlet/sim/world/empty.hpp"
#include "swiftlet/sim/world/field.hpp"
#include "tests/sim/world/world_support.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::objects_of;

// Calls check(point, class) for every corner of every triangle.
template <class Check>
void for_each_corner(const Scene& scene, const Check& check) {
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m)
      check((instance.T_world_mesh * vertex).cast<double>().eval(), mesh.surface_class);
  }
}

TEST(Empty, IsNothingOrAFlatGround) {
  EXPECT_EQ(make_empty({}, 1).num_triangles(), 0U);
  EmptyConfig config;
  config.ground = true;
  const Scene scene = make_empty(config, 1);
  const auto hit = test::trace(scene, {3, 4, 10}, -Vector3d::UnitZ());
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range_m, 10.0, 1e-9);
  EXPECT_EQ(hit->surface_class, SurfaceClass::kGround);
}

TEST(Field, NothingGrowsNearTheOrigin) {
  FieldConfig config;
  config.num_bushes = 200;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene scene = make_field(config, seed);
    EXPECT_EQ(objects_of(scene, SurfaceClass::kTrunk).size(), 12U);
    for_each_corner(scene, [&](const Vector3d& point, SurfaceClass surface_class) {
      if (surface_class == SurfaceClass::kGround) return;
      ASSERT_GE(point.head<2>().norm(), config.clear_radius_m - 1e-3);
    });
  }
}

TEST(Field, TreesStandOnTheHills) {
  FieldConfig config;
  config.relief.amplitude_m = 3.0;
  const Scene scene = make_field(config, 2);
  const Relief relief(config.relief, 2);
  for (const WorldObject& tree : objects_of(scene, SurfaceClass::kTrunk)) {
    EXPECT_NEAR(tree.position_world_m.z(), relief.height_m(tree.position_world_m.x(), tree.position_world_m.y()), 1e-9);
  }
}

TEST(Campus, RingAroundBuildingIsAlwaysFree) {
  const CampusConfig config;
  const Vector2d half = 0.5 * config.building_size_m;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const Scene scene = make_campus(config, seed);
    EXPECT_GE(objects_of(scene, SurfaceClass::kTrunk).size(), 15U);
    for_each_corner(scene, [&](const Vector3d& point, SurfaceClass surface_class) {
      const double from_walls_m = (point.head<2>().cwiseAbs() - half).cwiseMax(0.0).norm();
      // Eaves, gutters and steps belong to the building and end within 1.2 m.
      if (from_walls_m < 1.2 || surface_class == SurfaceClass::kGround) return;
      if (from_walls_m >= config.free_ring_m - 1e-3) return;
      ASSERT_LE(point.z(), config.kerb_height_m + 1e-6) << name_of(surface_class);
    });
  }
}

TEST(Campus, BuildingHasItsOuterSize) {
  const CampusConfig config;
  const Scene scene = make_campus(config, 1);
  // At a pier between the corner and the first window.
  const auto west = test::trace(scene, {-30.0, -4.3, 1.5}, Vector3d::UnitX());
  const auto east = test::trace(scene, {30.0, 4.3, 1.5}, -Vector3d::UnitX());
  ASSERT_TRUE(west && east);
  EXPECT_EQ(west->surface_class, SurfaceClass::kBuilding);
  EXPECT_NEAR(60.0 - west->range_m - east->range_m, 14.0, 1e-4);
  const auto ridge = test::trace(scene, {0.0, 0.001, 50.0}, -Vector3d::UnitZ());
  ASSERT_TRUE(ridge);
  EXPECT_NEAR(50.0 - ridge->range_m, config.wall_height_m + config.roof_height_m + 0.18, 0.01);
}

TEST(Campus, HasRequestedTreesLampsAndCars) {
  CampusConfig config;
  for (const int count : {0, 1, 3}) {
    config.num_trees = config.num_lamps = config.num_cars = count;
    const Scene scene = make_campus(config, 1);
    for (const SurfaceClass surface_class : {SurfaceClass::kTrunk, SurfaceClass::kPillar, SurfaceClass::kObject})
      EXPECT_EQ(objects_of(scene, surface_class).size(), static_cast<std::size_t>(count)) << name_of(surface_class);
  }
}

TEST(Campus, UnitesWallsWindowsAndRoof) {
  const auto buildings = test::bounds_of_each(make_campus({}, 1), SurfaceClass::kBuilding);
  ASSERT_EQ(buildings.size(), 1U);
  EXPECT_EQ(buildings.begin()->first, 1);
}

CampusConfig bare_ground_campus() {
  CampusConfig config;
  config.num_trees = config.num_lamps = config.num_cars = 0;
  return config;
}

// Looked at straight, at the height of a face: walls with openings in them, the same from the left as from the right.
TEST(Campus, HasSymmetricWindowsOnEveryFacade) {
  const CampusConfig config = bare_ground_campus();
  const Scene scene = make_campus(config, 1);
  const Vector2d half = 0.5 * config.building_size_m;
  for (int facade = 0; facade < 4; ++facade) {
    const double turn_rad = 0.5 * std::numbers::pi * facade;
    const Vector3d along(std::cos(turn_rad), std::sin(turn_rad), 0), inward(-along.y(), along.x(), 0);
    const double half_length_m = facade % 2 == 0 ? half.x() : half.y(),
                 to_face_m = facade % 2 == 0 ? half.y() : half.x();
    const auto depth_m = [&](double s_m) {
      const auto hit = test::trace(scene, Vector3d(0, 0, 1.5) + s_m * along - (to_face_m + 0.5) * inward, inward);
      return hit ? hit->range_m - 0.5 : 1e9;
    };
    int openings = 0;
    double before_m = 0.0;
    for (double s_m = -half_length_m + 0.33; s_m < 0.0; s_m += 0.12) {
      const double here_m = depth_m(s_m);
      ASSERT_NEAR(here_m, depth_m(-s_m), 1e-4) << "facade " << facade << " at " << s_m;
      ASSERT_LT(here_m, 0.35);  // the thickness of the wall: nothing looks inside
      if (before_m < 0.01 && here_m > 0.05) ++openings;
      before_m = here_m;
    }
    EXPECT_GE(openings, 1) << "facade " << facade;
  }
}

// From the wall outward: lawn, kerb, path of the configured width, kerb, lawn.
TEST(Campus, LeadsPathAroundBuildingAtDistance) {
  const CampusConfig config = bare_ground_campus();
  const Scene scene = make_campus(config, 1);
  const Vector2d half = 0.5 * config.building_size_m;
  const double begin_m = config.path_distance_m, end_m = begin_m + config.path_width_m, kerb_m = 0.12;
  for (const double along_m : {-0.83 * half.y(), 0.0, 0.57 * half.y()}) {
    for (const double from_wall_m : {begin_m - kerb_m - 0.01, begin_m - kerb_m + 0.01, begin_m - 0.01, begin_m + 0.01,
                                     end_m - 0.01, end_m + 0.01, end_m + kerb_m - 0.01, end_m + kerb_m + 0.01}) {
      const double beyond_m = std::max(begin_m - from_wall_m, from_wall_m - end_m);
      const double expected_m = beyond_m < 0.0 ? 0.01 : beyond_m < kerb_m ? config.kerb_height_m : 0.0;
      for (const double side : {-1.0, 1.0}) {
        for (const Vector3d& place : {Vector3d(side * (half.x() + from_wall_m), along_m, 2.0),
                                      Vector3d(along_m, side * (half.y() + from_wall_m), 2.0)}) {
          const auto hit = test::trace(scene, place, -Vector3d::UnitZ());
          ASSERT_TRUE(hit);
          EXPECT_NEAR(2.0 - hit->range_m, expected_m, 1e-4) << place.transpose();
        }
      }
    }
  }
}

TEST(Field, GroundCoversExactlyItsRectangle) {
  FieldConfig config;
  config.num_trees = config.num_bushes = 0;
  for (const double amplitude_m : {0.0, 2.0}) {
    config.relief.amplitude_m = amplitude_m;
    const auto ground = test::bounds_of(make_field(config, 1), SurfaceClass::kGround);
    EXPECT_TRUE(ground.min().head<2>().isApprox(-0.5 * config.size_m, 1e-5));
    EXPECT_TRUE(ground.max().head<2>().isApprox(0.5 * config.size_m, 1e-5));
  }
}

}  // namespace
}  // namespace swiftlet::sim
