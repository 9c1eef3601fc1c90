// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/boxes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "swiftlet/sim/scenario/scenario.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

/// A LiDAR 0.3 m above uav1 at the origin at 10 m height, uav2 20 m ahead of it, and what stands between them.
class BoxesTest : public ::testing::Test {
 protected:
  BoxesTest() {
    const Airframe airframe = Scenario().vehicles[0].airframe;
    shapes.assign(3, std::make_shared<const VehicleShape>(make_vehicle_shape(airframe)));
    scene.add_wall({-90, -90, 0}, {90, -90, 0}, {90, 90, 0}, {-90, 90, 0}, SurfaceClass::kGround);
    auto beams = std::make_shared<BeamTable>();
    beams->rows = 64;
    beams->cols = 720;
    for (int row = 0; row < 64; ++row) {
      for (int column = 0; column < 720; ++column) {
        const double azimuth = -column * std::numbers::pi / 360.0;
        const double elevation = (31.5 - row) * std::numbers::pi / 180.0 * 0.7;
        beams->directions_lidar.emplace_back(std::cos(elevation) * std::cos(azimuth),
                                             std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
        beams->origins_lidar.emplace_back(0, 0, 0);
      }
    }
    for (int column = 0; column < 720; ++column)
      beams->column_offset_s.push_back(0.1F * static_cast<float>(column) / 720.0F);
    scan.scan.beams = beams;
    scan.scan.duration = 100'000'000;
    scan.scan.range_max_m = 50.0;
    scan.scan.T_body_lidar.translation() = Vector3(0, 0, 0.3);
    const auto size = static_cast<std::size_t>(beams->size());
    scan.scan.range_m.assign(size, 0.0F);
    scan.truth.surface_class.assign(size, 0);
    scan.truth.instance.assign(size, 0);
  }

  /// Boxes of uav2 and uav3, which fly with a constant velocity from these places.
  std::vector<VehicleBox> boxes(const Vector3& p2, const Vector3& p3, const Vector3& v2 = Vector3::Zero()) {
    StateHistory truth(3, 200);
    for (int k = 0; k <= 110; ++k) {
      for (VehicleId v = 0; v < 3; ++v) {
        VehicleState state;
        state.t = k * 1'000'000;
        const double t_s = to_seconds(state.t);
        state.p_world_m = v == 0 ? Vector3(0, 0, 10) : v == 1 ? Vector3(p2 + t_s * v2) : p3;
        if (v == 1) state.v_world_mps = v2;
        truth.push(v, state);
      }
    }
    BoxMaker maker(std::make_shared<const StaticScene>(scene.scene()), shapes, 0);
    return maker.boxes(scan, truth);
  }

  TestScene scene;
  std::vector<std::shared_ptr<const VehicleShape>> shapes;
  LabeledScan scan;
};

const Vector3 kFarBehind(-40, 30, 12);

TEST_F(BoxesTest, StandWhereTheVehicleIsAndAreAsLargeAsItIs) {
  const auto found = boxes({20, 0, 10.3}, kFarBehind);
  ASSERT_EQ(found.size(), 2U);
  const VehicleBox& box = found[0];
  EXPECT_EQ(box.vehicle, 1);
  EXPECT_NEAR(box.T_lidar_box.translation().x(), 20.0, 0.05);
  EXPECT_NEAR(box.T_lidar_box.translation().y(), 0.0, 1e-6);
  EXPECT_NEAR(box.range_m, box.T_lidar_box.translation().norm(), 1e-12);
  EXPECT_EQ(box.num_points, 0);
  // Hubs at 0.25 m on the diagonals and propellers of 0.15 m: 2 (0.25 / sqrt 2 + 0.15).
  const double width_m = 2.0 * (0.25 / std::sqrt(2.0) + 0.15);
  EXPECT_NEAR(box.size_m.x(), width_m, 0.02);
  EXPECT_NEAR(box.size_m.y(), width_m, 0.02);
  EXPECT_GT(box.size_m.z(), 0.2);
  EXPECT_LT(box.size_m.z(), 0.6);
}

TEST_F(BoxesTest, AreThoseOfTheTimeAtWhichTheBeamsPass) {
  // Straight to the right, at azimuth -90 degrees: the beams pass after a quarter of the sweep, 25 ms.
  const auto found = boxes({0, -20, 10.3}, kFarBehind, {8, 0, 0});
  EXPECT_NEAR(to_seconds(found[0].t), 0.025, 0.002);
  EXPECT_NEAR(found[0].T_lidar_box.translation().x(), 8 * to_seconds(found[0].t), 0.01);
  EXPECT_EQ(found[0].v_world_mps, Vector3(8, 0, 0));
}

TEST_F(BoxesTest, CountTheirPointsAndTakeTheirMeanTime) {
  const int columns[] = {100, 101, 104};
  for (const int column : columns) {
    const auto i = static_cast<std::size_t>(30 * 720 + column);
    scan.scan.range_m[i] = 20.0F;
    scan.truth.surface_class[i] = 300;
    scan.truth.instance[i] = 2;
  }
  const auto found = boxes({20, 0, 10.3}, kFarBehind);
  EXPECT_EQ(found[0].num_points, 3);
  EXPECT_EQ(found[1].num_points, 0);
  EXPECT_NEAR(to_seconds(found[0].t), 0.1 * (100 + 101 + 104) / 3.0 / 720.0, 1e-6);
}

TEST_F(BoxesTest, AVehicleInTheOpenIsVisibleAsAWhole) {
  const auto found = boxes({20, 0, 10.3}, kFarBehind);
  EXPECT_DOUBLE_EQ(found[0].visible_fraction, 1.0);
}

TEST_F(BoxesTest, AVehicleBehindAWallIsNotVisibleAndHalfAWallHidesHalf) {
  scene.add_box({10, -5, 0}, {10.1F, 5, 20});
  EXPECT_DOUBLE_EQ(boxes({20, 0, 10.3}, kFarBehind)[0].visible_fraction, 0.0);
  TestScene half;
  half.add_box({10, -5, 0}, {10.1F, 0, 20});
  scene = half;
  EXPECT_NEAR(boxes({20, 0, 10.3}, kFarBehind)[0].visible_fraction, 0.5, 0.1);
}

TEST_F(BoxesTest, OneVehicleHidesAnother) {
  // Same size at half the distance: it covers all of the one behind, which looks half as large.
  const auto found = boxes({20, 0, 10.3}, {6, 0, 10.3});
  EXPECT_LT(found[0].visible_fraction, 0.5);
  EXPECT_DOUBLE_EQ(found[1].visible_fraction, 1.0);
}

TEST_F(BoxesTest, WhatIsOutOfReachOrOutOfTheFieldOfViewIsNotVisible) {
  EXPECT_DOUBLE_EQ(boxes({55, 0, 10.3}, kFarBehind)[0].visible_fraction, 0.0);
  EXPECT_DOUBLE_EQ(boxes({5, 0, 20}, kFarBehind)[0].visible_fraction, 0.0);  // 63 degrees up
}

TEST_F(BoxesTest, TheCarrierHidesWhatLiesBehindItsArm) {
  // 18 degrees down, over the hub of a rotor 0.25 m away and 0.07 m below the sensor.
  scan.scan.T_body_lidar.translation() = Vector3(0, 0, 0.12);
  const double down_m = 2.0 * std::tan(18.0 * std::numbers::pi / 180.0);
  EXPECT_LT(boxes({std::sqrt(2.0), std::sqrt(2.0), 10.12 - down_m}, kFarBehind)[0].visible_fraction, 0.95);
  EXPECT_DOUBLE_EQ(boxes({std::sqrt(2.0), std::sqrt(2.0), 10.42}, kFarBehind)[0].visible_fraction, 1.0);
}

}  // namespace
}  // namespace swiftlet::sim
