// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "sim/world/dice.hpp"
#include "swiftlet/sim/world/hall.hpp"
#include "swiftlet/sim/world/two_rooms_gap.hpp"
#include "swiftlet/sim/world/warehouse.hpp"
#include "tests/sim/world/world_support.hpp"
#include "tests/support/config_checks.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3d;
using test::free_width_m;
using test::objects_of;

/// Checks that no bounding box of a triangle reaches into the box.
void expect_empty(const Scene& scene, const Vector3d& low, const Vector3d& high) {
  const Eigen::AlignedBox3d box(low, high);
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const auto& triangle : mesh.triangles) {
      Eigen::AlignedBox3d own;
      for (const std::uint32_t corner : triangle)
        own.extend((instance.T_world_mesh * mesh.vertices_mesh_m[corner]).cast<double>());
      ASSERT_TRUE(box.intersection(own).isEmpty()) << name_of(mesh.surface_class) << " " << instance.instance;
    }
  }
}

TEST(Warehouse, DoorHasSetWidthAndHeight) {
  for (const double width_m : {1.2, 1.1, 1.0, 0.9}) {
    WarehouseConfig config;
    config.door_width_m = width_m;
    const Scene scene = make_warehouse(config, 1);
    const Vector3d in_door(0.5 * config.size_m.x() + 0.1, 0.0, 1.2);
    EXPECT_NEAR(free_width_m(scene, in_door, Vector3d::UnitY()), width_m, 1e-4);
    EXPECT_NEAR(free_width_m(scene, in_door, Vector3d::UnitZ()), config.door_height_m, 1e-4);
    EXPECT_FALSE(test::trace(scene, in_door, Vector3d::UnitX()));  // out of the building
    ASSERT_EQ(objects_of(scene, SurfaceClass::kDoor).size(), 1U);
    EXPECT_EQ(test::attribute(objects_of(scene, SurfaceClass::kDoor)[0], "width_m"), width_m);
  }
}

TEST(Warehouse, GateIsClosedBesideTheDoor) {
  const Scene scene = make_warehouse({}, 1);
  const auto hit = test::trace(scene, {18.0, 1.2, 1.5}, Vector3d::UnitX());
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->surface_class, SurfaceClass::kDoor);
}

TEST(Warehouse, AislesAreFreeForEverySeed) {
  WarehouseConfig config;
  config.fill = 1.0;
  ASSERT_EQ(config.num_double_rows(), 4);
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene scene = make_warehouse(config, seed);
    for (int aisle = 0; aisle <= config.num_double_rows(); ++aisle) {
      const double y = config.aisle_center_y_m(aisle);
      expect_empty(scene, {-19.5, y - 1.4, 0.1}, {19.5, y + 1.4, 8.4});
    }
    for (const double side : {-1.0, 1.0}) {  // cross aisles, outside the pillars
      const double near = side * (0.5 * config.num_bays() * config.bay_width_m + 0.8);
      const double far = side * 19.5;
      expect_empty(scene, {std::min(near, far), -12.8, 0.1}, {std::max(near, far), 12.8, 8.4});
    }
  }
}

TEST(Warehouse, KeepsAisleWidthsAndEndAisles) {
  WarehouseConfig config;
  config.fill = 0.0;
  for (const double length_m : {36.0, 38.8, 42.2}) {
    config.size_m.x() = length_m;
    const double racks_end_m = 0.5 * config.num_bays() * config.bay_width_m;
    const double left_m = 0.5 * config.size_m.x() - racks_end_m;
    EXPECT_GE(left_m, 5.0);
    EXPECT_LT(left_m, 5.0 + 0.5 * config.bay_width_m);
    const Scene scene = make_warehouse(config, 1);
    ASSERT_GE(config.aisle_width(), config.aisle_width_m);
    for (int aisle = 0; aisle <= config.num_double_rows(); ++aisle) {
      const Vector3d at_uprights_m(racks_end_m - config.bay_width_m, config.aisle_center_y_m(aisle), 0.2);
      EXPECT_NEAR(free_width_m(scene, at_uprights_m, Vector3d::UnitY()), config.aisle_width(), 1e-4);
    }
  }
}

TEST(Warehouse, FillSetsTheNumberOfPallets) {
  WarehouseConfig config;
  const double places = 2.0 * config.num_double_rows() * config.num_bays() * config.levels * 2.0;
  config.fill = 1.0;
  EXPECT_EQ(objects_of(make_warehouse(config, 1), SurfaceClass::kPallet).size(), places);
  config.fill = 0.0;
  EXPECT_EQ(objects_of(make_warehouse(config, 1), SurfaceClass::kPallet).size(), 0U);
  config.fill = 0.7;
  const auto some = objects_of(make_warehouse(config, 1), SurfaceClass::kPallet).size();
  EXPECT_NEAR(some, 0.7 * places, 5 * std::sqrt(0.21 * places));
}

TEST(Warehouse, TapeIsRetroreflectiveAndOptional) {
  WarehouseConfig config;
  const auto num_retro = [](const Scene& scene) {
    std::size_t triangles = 0;
    for (const Instance& instance : scene.instances) {
      const Mesh& mesh = scene.meshes[instance.mesh];
      EXPECT_EQ(scene.materials[mesh.material].retroreflective, mesh.surface_class == SurfaceClass::kMarking);
      if (scene.materials[mesh.material].retroreflective) triangles += mesh.triangles.size();
    }
    return triangles;
  };
  EXPECT_GT(num_retro(make_warehouse(config, 1)), 100U);
  config.tape = false;
  EXPECT_EQ(num_retro(make_warehouse(config, 1)), 0U);
}

TEST(Warehouse, NumbersThingsPerClassWithoutGaps) {
  const Scene scene = make_warehouse({}, 1);
  for (const SurfaceClass surface_class :
       {SurfaceClass::kWall, SurfaceClass::kDoor, SurfaceClass::kCeiling, SurfaceClass::kPillar, SurfaceClass::kRack,
        SurfaceClass::kPallet, SurfaceClass::kMarking}) {
    const auto numbers = test::bounds_of_each(scene, surface_class);
    ASSERT_FALSE(numbers.empty()) << name_of(surface_class);
    EXPECT_EQ(numbers.begin()->first, 1) << name_of(surface_class);
    EXPECT_EQ(numbers.rbegin()->first, numbers.size()) << name_of(surface_class);
  }
}

TEST(Warehouse, RejectsDoorsWiderThanTheGate) {
  WarehouseConfig config;
  config.door_width_m = 5.0;
  EXPECT_THAT(swiftlet::test::ConfigChecks(config).problems(),
              testing::ElementsAre(testing::HasSubstr("door_width_m")));
}

TEST(TwoRoomsGap, WidthFollowsEquationOneUnlessSet) {
  TwoRoomsGapConfig config;
  EXPECT_DOUBLE_EQ(config.gap_width(), 2 * 0.8 + 1.5 * 0.1);
  config.safe_distance_m = 0.5;
  EXPECT_DOUBLE_EQ(config.gap_width(), 1.15);
  config.gap_width_m = 0.93;
  EXPECT_DOUBLE_EQ(config.gap_width(), 0.93);
}

TEST(TwoRoomsGap, KeepsItsWidthAtAnyRotation) {
  for (const double yaw_deg : {0.0, 17.0, 45.0, 90.0, 123.4, -71.0}) {
    TwoRoomsGapConfig config;
    config.yaw_deg = yaw_deg;
    config.position_m = {3.0, -7.0};
    config.gap_offset_m = 1.2;
    config.gap_height_m = 2.5;
    const Scene scene = make_two_rooms_gap(config, 1);
    const double yaw_rad = yaw_deg * std::numbers::pi / 180.0;
    const Vector3d through(std::cos(yaw_rad), std::sin(yaw_rad), 0);
    const Vector3d across(-through.y(), through.x(), 0);
    const Vector3d in_gap(3.0, -7.0, 1.0);
    EXPECT_NEAR(free_width_m(scene, in_gap, across), 1.75, 1e-4);
    EXPECT_NEAR(free_width_m(scene, in_gap, Vector3d::UnitZ()), 2.5, 1e-4);
    // Both rooms have their length, and their width is shifted by the offset.
    EXPECT_NEAR(free_width_m(scene, in_gap, through), 2 * config.room_size_m.x() + 0.2, 1e-4);
    const auto left = test::trace(scene, in_gap + 2.0 * through, across);
    const auto right = test::trace(scene, in_gap + 2.0 * through, -across);
    ASSERT_TRUE(left && right);
    EXPECT_NEAR(left->range_m, 5.0 + 1.2, 1e-4);
    EXPECT_NEAR(right->range_m, 5.0 - 1.2, 1e-4);
  }
}

TEST(TwoRoomsGap, RoomsAreClosedAllAround) {
  TwoRoomsGapConfig config;
  config.yaw_deg = 33.0;
  const Scene scene = make_two_rooms_gap(config, 1);
  Random random(1, "test");
  Dice dice(random, 0);
  for (int i = 0; i < 3000; ++i) {
    const auto hit =
        test::trace(scene, {3.0 * std::cos(0.5), 3.0 * std::sin(0.5), 2.0}, dice.direction().cast<double>());
    ASSERT_TRUE(hit);
    ASSERT_LT(hit->range_m, 20.0);
  }
}

TEST(Hall, WallHidesWhatIsBehindIt) {
  const HallConfig config;
  const Scene scene = make_hall(config, 1);
  const auto sees = [&](const Vector3d& a, const Vector3d& b) {
    const auto hit = test::trace(scene, a, (b - a).normalized());
    return !hit || hit->range_m > (b - a).norm();
  };
  const Vector3d observer(-6.0, 0.0, 2.0);
  EXPECT_FALSE(sees(observer, {4.0, 0.0, 2.0}));
  EXPECT_TRUE(sees(observer, {-1.0, 0.0, 2.0}));
  EXPECT_TRUE(sees(observer, {4.0, 4.0, 2.0}));
}

TEST(Hall, HidingWallHasTheSetHeight) {
  for (const double height_m : {0.6, 1.4, 0.0}) {
    HallConfig config;
    config.hide_height_m = height_m;
    const Scene scene = make_hall(config, 1);
    const double top_m = height_m > 0.0 ? height_m : config.size_m.z();
    for (const double z_m : {top_m - 0.1, top_m + 0.1}) {
      if (z_m > config.size_m.z()) continue;
      const auto hit = test::trace(scene, {-6.0, 0.0, z_m}, Vector3d::UnitX());
      ASSERT_TRUE(hit.has_value());
      EXPECT_EQ(hit->range_m < 10.0, z_m < top_m) << height_m << " m, at " << z_m;
    }
  }
}

TEST(Hall, KeepsCratesInTheirZone) {
  HallConfig config;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const Scene scene = make_hall(config, seed);
    EXPECT_EQ(objects_of(scene, SurfaceClass::kObject).size(), 8U);
    for (const Instance& instance : scene.instances) {
      const Mesh& mesh = scene.meshes[instance.mesh];
      if (mesh.surface_class != SurfaceClass::kObject) continue;
      Eigen::AlignedBox3d box;
      for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) box.extend(vertex.cast<double>());
      const double from_wall_x = std::min(box.min().x() + 7.5, 7.5 - box.max().x());
      const double from_wall_y = std::min(box.min().y() + 5.0, 5.0 - box.max().y());
      EXPECT_NEAR(std::min(from_wall_x, from_wall_y), 0.0, 1e-4);
      const bool is_in_zone = box.max().x() <= -6.5 + 1e-4 || box.min().x() >= 6.5 - 1e-4 ||
                              box.max().y() <= -4.0 + 1e-4 || box.min().y() >= 4.0 - 1e-4;
      EXPECT_TRUE(is_in_zone);
    }
  }
}

}  // namespace
}  // namespace swiftlet::sim
