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

/// uav1 hovers at (0, 0, 10) m with a LiDAR 0.3 m above its center. Each test places uav2, uav3 and occluders.
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
    scan.truth.T_body_lidar = scan.scan.T_body_lidar;
    const auto size = static_cast<std::size_t>(beams->size());
    scan.scan.range_m.assign(size, 0.0F);
    scan.truth.surface_class.assign(size, 0);
    scan.truth.instance.assign(size, 0);
  }

  /// Boxes of uav2, which flies from p2 with the velocity v2, and of uav3, which hovers at p3.
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

TEST_F(BoxesTest, MatchTheVehiclePositionAndSize) {
  const auto found = boxes({20, 0, 10.3}, kFarBehind);
  ASSERT_EQ(found.size(), 2U);
  const VehicleBox& box = found[0];
  EXPECT_EQ(box.vehicle, 1);
  EXPECT_NEAR(box.T_lidar_box.translation().x(), 20.0, 0.05);
  EXPECT_NEAR(box.T_lidar_box.translation().y(), 0.0, 1e-6);
  EXPECT_NEAR(box.range_m, box.T_lidar_box.translation().norm(), 1e-12);
  EXPECT_EQ(box.num_points, 0);
  // The rotor hubs are on the diagonals, 0.25 m from the center; propellers have a radius of 0.15 m.
  const double width_m = 2.0 * (0.25 / std::sqrt(2.0) + 0.15);
  EXPECT_NEAR(box.size_m.x(), width_m, 0.02);
  EXPECT_NEAR(box.size_m.y(), width_m, 0.02);
  EXPECT_GT(box.size_m.z(), 0.2);
  EXPECT_LT(box.size_m.z(), 0.6);
}

TEST_F(BoxesTest, HaveTimeOfPassingBeams) {
  // The beams turn clockwise from the x axis: they pass uav2, at azimuth -90 degrees, after a quarter of the sweep.
  const auto found = boxes({0, -20, 10.3}, kFarBehind, {8, 0, 0});
  EXPECT_NEAR(to_seconds(found[0].t), 0.025, 0.002);
  EXPECT_NEAR(found[0].T_lidar_box.translation().x(), 8 * to_seconds(found[0].t), 0.01);
  EXPECT_EQ(found[0].v_world_mps, Vector3(8, 0, 0));
}

TEST_F(BoxesTest, LoseVisibleFractionBehindWalls) {
  scene.add_box({10, -5, 0}, {10.1F, 5, 20});
  EXPECT_DOUBLE_EQ(boxes({20, 0, 10.3}, kFarBehind)[0].visible_fraction, 0.0);
  TestScene half;
  half.add_box({10, -5, 0}, {10.1F, 0, 20});
  scene = half;
  EXPECT_NEAR(boxes({20, 0, 10.3}, kFarBehind)[0].visible_fraction, 0.5, 0.1);
}

TEST_F(BoxesTest, LoseVisibleFractionBehindVehicles) {
  // uav3 at 6 m appears three times as large as uav2 behind it at 20 m.
  const auto found = boxes({20, 0, 10.3}, {6, 0, 10.3});
  EXPECT_LT(found[0].visible_fraction, 0.5);
  EXPECT_DOUBLE_EQ(found[1].visible_fraction, 1.0);
}

TEST_F(BoxesTest, AreInvisibleOutsideRangeOrView) {
  EXPECT_DOUBLE_EQ(boxes({55, 0, 10.3}, kFarBehind)[0].visible_fraction, 0.0);
  EXPECT_DOUBLE_EQ(boxes({5, 0, 20}, kFarBehind)[0].visible_fraction, 0.0);  // elevation 63 degrees
}

TEST_F(BoxesTest, CountOnlyPointsReturnedByVehicles) {
  const auto put = [&](int column, float range_m, int surface_class, int instance) {
    const auto i = static_cast<std::size_t>(30 * 720 + column);
    scan.scan.range_m[i] = range_m;
    scan.truth.surface_class[i] = static_cast<std::uint16_t>(surface_class);
    scan.truth.instance[i] = static_cast<std::uint16_t>(instance);
  };
  put(100, 20.0F, 300, 2);
  put(101, 0.0F, 300, 2);   // no return
  put(102, 20.0F, 40, 2);   // class ground
  put(103, 20.0F, 300, 1);  // uav1, which carries the LiDAR
  put(104, 20.0F, 300, 3);
  put(105, 20.0F, 300, 3);
  put(106, 20.0F, 300, 4);  // no vehicle has this instance
  put(107, 20.0F, 300, 0);
  const auto found = boxes({20, 0, 10.3}, kFarBehind);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].num_points, 1);
  EXPECT_EQ(found[1].vehicle, 2);
  EXPECT_EQ(found[1].num_points, 2);
  EXPECT_NEAR(to_seconds(found[1].t), 0.1 * 104.5 / 720.0, 1e-6);
}

TEST_F(BoxesTest, HaveBodyPoseAtTheirTime) {
  const Vector3 v2(3, -2, 1);
  const auto found = boxes({20, 5, 10.3}, kFarBehind, v2);
  const VehicleBox& box = found[0];
  // The center of the box lies on the vertical through the center of mass, above or below it.
  const Vector3 body_m = Vector3(20, 5, 10.3) + to_seconds(box.t) * v2;
  EXPECT_LT((box.T_world_box.translation() - body_m).head<2>().norm(), 0.02);
  EXPECT_LT(std::abs((box.T_world_box.translation() - body_m).z()), 0.3);
  EXPECT_LT((box.T_world_box.translation() - box.T_lidar_box.translation() - Vector3(0, 0, 10.3)).norm(), 1e-9)
      << "uav1 hovers, its LiDAR 0.3 m above its center";
  EXPECT_EQ(box.v_world_mps, v2);
}

TEST_F(BoxesTest, DeriveFieldOfViewFromBeams) {
  const auto direction = [](double azimuth_deg, double elevation_deg) {
    const double a = azimuth_deg * std::numbers::pi / 180.0, e = elevation_deg * std::numbers::pi / 180.0;
    return Vector3(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
  };
  // At 45 m a vehicle is less than a degree wide.
  const auto visible_at = [&](double azimuth_deg, double elevation_deg, double beam_deg) {
    auto beams = std::make_shared<BeamTable>();
    beams->rows = beams->cols = 1;
    beams->directions_lidar = {direction(beam_deg, 1.0).cast<float>()};
    beams->origins_lidar = {Eigen::Vector3f::Zero()};
    beams->column_offset_s = {0.0F};
    scan.scan.beams = beams;
    scan.scan.range_m = {0.0F};
    scan.truth.surface_class = scan.truth.instance = {0};
    return boxes(Vector3(0, 0, 10.3) + 45.0 * direction(azimuth_deg, elevation_deg), kFarBehind)[0].visible_fraction;
  };
  EXPECT_EQ(visible_at(1.0, 1.0, 1.0), 1.0);
  EXPECT_EQ(visible_at(5.0, 1.0, 1.0), 0.0) << "beside the beam";
  EXPECT_EQ(visible_at(-3.0, 1.0, 1.0), 0.0);
  EXPECT_EQ(visible_at(1.0, 5.0, 1.0), 0.0) << "above the beam";
  EXPECT_EQ(visible_at(1.0, -3.0, 1.0), 0.0);
  for (const double beam_deg : {179.0, -179.0}) {
    EXPECT_EQ(visible_at(beam_deg, 1.0, beam_deg), 1.0);
    EXPECT_EQ(visible_at(-beam_deg, 1.0, beam_deg), 1.0) << "across the wrap of the azimuth at 180 degrees";
    EXPECT_EQ(visible_at(-std::copysign(175.0, beam_deg), 1.0, beam_deg), 0.0);
  }
}

TEST_F(BoxesTest, TakeNearestBeamTimeWithoutPoints) {
  for (const double azimuth_deg : {-10.0, -100.0, -200.0, -350.0}) {
    const double a = azimuth_deg * std::numbers::pi / 180.0;
    const auto found = boxes(Vector3(20.0 * std::cos(a), 20.0 * std::sin(a), 10.3), kFarBehind);
    EXPECT_NEAR(to_seconds(found[0].t), 0.1 * -azimuth_deg / 360.0, 2e-4) << azimuth_deg;
  }
}

TEST_F(BoxesTest, ArePartlyOccludedByNarrowPosts) {
  // A post in front of uav2 covers about half of the width between its hubs.
  const auto whole = boxes({20, 0, 10.3}, kFarBehind)[0];
  const double half_width_m = 0.25 / std::sqrt(2.0);
  scene.add_box({18.0F, static_cast<float>(-0.5 * half_width_m), 0},
                {18.1F, static_cast<float>(0.5 * half_width_m), 20});
  const double seen = boxes({20, 0, 10.3}, kFarBehind)[0].visible_fraction;
  EXPECT_LT(seen, whole.visible_fraction - 0.2);
  // In front of the post, uav2 is fully visible.
  EXPECT_EQ(boxes({16, 0, 10.3}, kFarBehind)[0].visible_fraction, 1.0);
}

TEST_F(BoxesTest, StayVisibleWithoutOccludersBetween) {
  EXPECT_EQ(boxes({20, 0, 10.3}, {10, 1.0, 10.3})[0].visible_fraction, 1.0);
  EXPECT_EQ(boxes({20, 0, 10.3}, {25, 0.0, 10.3})[0].visible_fraction, 1.0) << "uav3 behind uav2";
  EXPECT_EQ(boxes({20, 0, 10.3}, {-5, 0.0, 10.3})[0].visible_fraction, 1.0) << "uav3 behind the LiDAR";
  EXPECT_LT(boxes({20, 0, 10.3}, {10, 0.0, 10.3})[0].visible_fraction, 1.0);
}

}  // namespace
}  // namespace swiftlet::sim
