// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/physics/free_places.hpp"

#include <gtest/gtest.h>

#include "tests/sim/physics/flight.hpp"

namespace swiftlet::sim {
namespace {

// A table of 2 m, 2 m high, on the ground.
StaticScene table_on_the_ground() {
  TestScene builder;
  builder.add_wall({-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0}, SurfaceClass::kGround);
  builder.add_box({-1, -1, 0}, {1, 1, 2}, SurfaceClass::kObject);
  return StaticScene(builder.scene());
}

std::optional<NoRoom> room_at(const StaticScene& world, const Vector3& p_world_m,
                              const Airframe& airframe = test_quad()) {
  const std::vector<PhysicsVehicle> vehicles = {vehicle_at(p_world_m, airframe)};
  return FreePlaces(vehicles, PhysicsConfig{}, world).check(0, p_world_m);
}

TEST(FreePlaces, IncludeAirAndStandingSurfaces) {
  const StaticScene world = table_on_the_ground();
  const double legs_m = test_quad().leg_height_m;
  EXPECT_FALSE(room_at(world, {0, 0, 5}));
  EXPECT_FALSE(room_at(world, {5, 5, legs_m}));
  EXPECT_FALSE(room_at(world, {0, 0, 2 + legs_m}));
  EXPECT_FALSE(room_at(world, {30, 30, 1}));  // outside the world
}

TEST(FreePlaces, ReportSurfaceClassAndFreeHeight) {
  const StaticScene world = table_on_the_ground();
  const double legs_m = test_quad().leg_height_m;
  for (const double z_m : {2.0, 2.1}) {
    const auto in_the_table = room_at(world, {0, 0, z_m});
    ASSERT_TRUE(in_the_table) << z_m;
    EXPECT_EQ(in_the_table->surface_class, SurfaceClass::kObject);
    EXPECT_GT(in_the_table->depth_m, 0.03);
    EXPECT_NEAR(in_the_table->free_z_m, 2.0 + legs_m, 0.02);
    EXPECT_FALSE(room_at(world, {0, 0, in_the_table->free_z_m}));
  }
  const auto in_its_side = room_at(world, {1.1, 0, 1.0});
  ASSERT_TRUE(in_its_side);
  EXPECT_EQ(in_its_side->surface_class, SurfaceClass::kObject);
  const auto below = room_at(world, {5, 5, -3});
  ASSERT_TRUE(below);
  EXPECT_EQ(below->surface_class, SurfaceClass::kGround);
  EXPECT_NEAR(below->free_z_m, legs_m, 0.02);
}

// There is room under a ceiling just above its upper plate, but not if the plate intersects it.
TEST(FreePlaces, UseTheAirframesBodyHeight) {
  Airframe airframe = test_quad();
  airframe.body_height_m = 0.4;
  for (const double gap_m : {-0.09, 0.03}) {  // a few centimeters do not count
    TestScene builder;
    const auto z = static_cast<float>(10.0 + 0.2 + gap_m);
    builder.add_wall({-5, -5, z}, {5, -5, z}, {5, 5, z}, {-5, 5, z}, SurfaceClass::kCeiling);
    builder.add_wall({-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}, SurfaceClass::kGround);
    EXPECT_EQ(room_at(StaticScene(builder.scene()), {0, 0, 10}, airframe).has_value(), gap_m < 0.0);
  }
}

}  // namespace
}  // namespace swiftlet::sim
