// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "sim/world/relief.hpp"
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
  config.size_m = {30.0, 20.0};
  config.reflectivity = 0.27;
  const Scene scene = make_empty(config, 1);
  EXPECT_TRUE(scene.bounds_m.isApprox(Eigen::AlignedBox3d(Vector3d(-15, -10, 0), Vector3d(15, 10, 0)), 1e-6));
  EXPECT_EQ(scene.materials.at(0).reflectivity, 0.27F);
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
      if (from_walls_m >= 9.0 - 1e-3) return;
      ASSERT_LE(point.z(), 0.12 + 1e-6) << name_of(surface_class);
    });
  }
}

TEST(Campus, BuildingHasItsOuterSize) {
  const Scene scene = make_campus({}, 1);
  // At a pier between the corner and the first window.
  const auto west = test::trace(scene, {-30.0, -4.3, 1.5}, Vector3d::UnitX());
  const auto east = test::trace(scene, {30.0, 4.3, 1.5}, -Vector3d::UnitX());
  ASSERT_TRUE(west && east);
  EXPECT_EQ(west->surface_class, SurfaceClass::kBuilding);
  EXPECT_NEAR(60.0 - west->range_m - east->range_m, 14.0, 1e-4);
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

TEST(Clutter, StandsAtItsPlace) {
  EmptyConfig config;
  config.ground = true;
  config.clutter.things = {{.kind = ClutterThingConfig::Kind::kPost, .position_m = {2.0, 0.0}},
                           {.kind = ClutterThingConfig::Kind::kPerson, .position_m = {-3.0, 0.0}},
                           {.kind = ClutterThingConfig::Kind::kSign, .position_m = {0.0, 4.0}, .yaw_deg = 90.0}};
  const Scene scene = make_empty(config, 1);
  const auto front_m = [&](const Vector3d& direction, double height_m) {
    const auto hit = test::trace(scene, {0, 0, height_m}, direction);
    return hit && hit->surface_class == SurfaceClass::kObject ? hit->range_m : 0.0;
  };
  EXPECT_NEAR(front_m(Vector3d::UnitX(), 0.9), 1.8, 1e-6);
  EXPECT_EQ(front_m(Vector3d::UnitX(), 1.0), 0.0) << "a post ends at 0.95 m";
  EXPECT_NEAR(front_m(-Vector3d::UnitX(), 1.2), 2.8, 0.05);
  EXPECT_EQ(front_m(-Vector3d::UnitX(), 1.8), 0.0) << "a person ends at 1.75 m";
  EXPECT_NEAR(front_m(Vector3d::UnitY(), 2.0), 3.99, 1e-6);
  const auto people = objects_of(scene, SurfaceClass::kObject);
  ASSERT_EQ(people.size(), 3U);
  EXPECT_EQ(people[1].kind, "person");
}

TEST(Clutter, RandomThingsKeepTheirRing) {
  FieldConfig config;
  config.relief.amplitude_m = 2.0;
  config.clutter = {
      .num_posts = 20, .num_people = 20, .num_signs = 20, .center_m = {5, 5}, .radius_min_m = 4, .radius_max_m = 20};
  config.keep_clear.clearings = {{.center_m = {5, -5}, .radius_m = 4}};
  const Scene scene = make_field(config, 3);
  const Relief relief(config.relief, 3);
  const auto things = objects_of(scene, SurfaceClass::kObject);
  EXPECT_EQ(things.size(), 60U);
  for (const WorldObject& thing : things) {
    const Vector2d p = thing.position_world_m.head<2>();
    EXPECT_GE((p - Vector2d(5, 5)).norm(), 4.0);
    EXPECT_LE((p - Vector2d(5, 5)).norm(), 20.0);
    EXPECT_GE((p - Vector2d(5, -5)).norm(), 4.0) << "zones for flights stay free";
    EXPECT_NEAR(thing.position_world_m.z(), relief.height_m(p.x(), p.y()), 1e-9);
  }
}

}  // namespace
}  // namespace swiftlet::sim
