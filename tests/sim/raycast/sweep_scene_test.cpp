// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/raycast/sweep_scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

constexpr TimeNs kMs = 1'000'000;

std::shared_ptr<const StaticScene> nothing() { return std::make_shared<const StaticScene>(Scene{}); }

// A vehicle that is one square plate across the body's x axis.
std::shared_ptr<const VehicleShape> plate(float half_m = 0.5F) {
  auto shape = std::make_shared<VehicleShape>();
  Mesh mesh;
  mesh.vertices_mesh_m = {{0, -half_m, -half_m}, {0, half_m, -half_m}, {0, half_m, half_m}, {0, -half_m, half_m}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.part = VehiclePart::kBody;
  shape->meshes.push_back(mesh);
  shape->materials.resize(3);
  return shape;
}

std::shared_ptr<const VehicleShape> rotor_only() {
  auto shape = std::make_shared<VehicleShape>();
  shape->materials.resize(3);
  VehicleShape::RotorShape rotor;
  rotor.hub_body_m = {0.2F, 0.1F, 0.05F};
  rotor.radius_m = 0.3F;
  rotor.chord_m = 0.05F;
  shape->rotors.push_back(rotor);
  return shape;
}

std::shared_ptr<const VehicleShape> point() { return std::make_shared<const VehicleShape>(); }

VehicleState at_rest(const Vector3& p, TimeNs t) {
  VehicleState state;
  state.t = t;
  state.p_world_m = p;
  return state;
}

BeamPacket all_along(const Eigen::Vector3f& direction) {
  BeamPacket beams;
  beams.direction_x.fill(direction.x());
  beams.direction_y.fill(direction.y());
  beams.direction_z.fill(direction.z());
  for (int i = 0; i < kPacketSize; ++i) beams.firing[i] = i;
  return beams;
}

std::vector<Firing> firings_every(double step_s) {
  std::vector<Firing> firings(kPacketSize);
  for (int i = 0; i < kPacketSize; ++i) firings[i].offset_s = static_cast<float>(i * step_s);
  return firings;
}

TEST(SweepScene, MeetsVehiclesAtEachBeamsInstant) {
  SweepScene scene(nothing(), {point(), plate()}, 0, Pose::Identity(), 100.0);
  StateHistory history(2, 300);
  for (TimeNs t = 0; t <= 200 * kMs; t += kMs) {
    history.push(0, at_rest({0, 0, 0}, t));
    VehicleState target = at_rest({10.0 + 20.0 * to_seconds(t), 0, 0}, t);
    target.v_world_mps = {20, 0, 0};
    history.push(1, target);
  }
  scene.set_firings(firings_every(0.006));
  scene.begin(history, 50 * kMs, 100 * kMs);
  PacketHits hits;
  scene.trace(all_along(Eigen::Vector3f::UnitX()), false, hits);
  for (int i = 0; i < kPacketSize; ++i) {
    EXPECT_NEAR(hits.range_m[i], 10.0 + 20.0 * (0.05 + 0.006 * i), 1e-4) << i;
    EXPECT_NEAR(hits.cos_incidence[i], 1.0, 1e-6);
    const SweepSurface& surface = scene.surfaces()[hits.surface[i]];
    EXPECT_EQ(surface.surface_class, SurfaceClass::kVehicle);
    EXPECT_EQ(surface.instance, 2);
    EXPECT_EQ(surface.vehicle, 1);
    EXPECT_EQ(surface.part, VehiclePart::kBody);
  }
  // Frozen: all at the start.
  scene.begin(history, 50 * kMs, 0);
  scene.trace(all_along(Eigen::Vector3f::UnitX()), false, hits);
  for (const float range : hits.range_m) EXPECT_NEAR(range, 11.0, 1e-5);
}

TEST(SweepScene, StartsBeamsFromInstantaneousSensorPose) {
  TestScene world;
  world.add_wall({30, -50, -50}, {30, 50, -50}, {30, 50, 50}, {30, -50, 50}, SurfaceClass::kWall, 9);
  const Pose T_body_lidar = make_pose({0.1, 0, 0.2}, Eigen::Quaterniond::Identity());
  SweepScene scene(std::make_shared<const StaticScene>(world.scene()), {point()}, 0, T_body_lidar, 100.0);
  StateHistory history(1, 300);
  for (TimeNs t = 0; t <= 100 * kMs; t += kMs) {  // flies at the wall and turns at 3 rad/s
    VehicleState state = at_rest({8.0 * to_seconds(t), 0, 0}, t);
    state.v_world_mps = {8, 0, 0};
    state.q_world_body = Eigen::AngleAxisd(3.0 * to_seconds(t), Vector3::UnitZ());
    history.push(0, state);
  }
  scene.set_firings(firings_every(0.006));
  scene.begin(history, 0, 100 * kMs);
  PacketHits hits;
  scene.trace(all_along(Eigen::Vector3f::UnitX()), false, hits);
  for (int i = 0; i < kPacketSize; ++i) {
    const double t = 0.006 * i;
    const double x = 8.0 * t + 0.1 * std::cos(3.0 * t);
    EXPECT_NEAR(hits.range_m[i], (30.0 - x) / std::cos(3.0 * t), 2e-4) << i;
    EXPECT_NEAR(hits.cos_incidence[i], std::cos(3.0 * t), 1e-5) << i;
    EXPECT_NEAR(scene.T_world_lidar(i).translation().x(), x, 2e-5) << i;
    EXPECT_NEAR(scene.T_world_lidar(i).translation().z(), 0.2, 1e-9) << i;
  }
}

TEST(SweepScene, MeetsTurningVehicleInCurrentAttitude) {
  SweepScene scene(nothing(), {point(), plate(2.0F)}, 0, Pose::Identity(), 100.0);
  StateHistory history(2, 300);
  for (TimeNs t = 0; t <= 100 * kMs; t += kMs) {
    history.push(0, at_rest({0, 0.3, 0}, t));
    VehicleState target = at_rest({10, 0, 0}, t);
    target.q_world_body = Eigen::AngleAxisd(4.0 * to_seconds(t), Vector3::UnitZ());
    history.push(1, target);
  }
  scene.set_firings(firings_every(0.006));
  scene.begin(history, 0, 100 * kMs);
  PacketHits hits;
  scene.trace(all_along(Eigen::Vector3f::UnitX()), false, hits);
  // The plate is the line through (10, 0) turned by a: at y = 0.3 its x is 10 - 0.3 tan a.
  for (int i = 0; i < kPacketSize; ++i) {
    EXPECT_NEAR(hits.range_m[i], 10.0 - 0.3 * std::tan(4.0 * 0.006 * i), 1e-4) << i;
  }
}

TEST(SweepScene, MeetsNearestOfWorldAndVehicles) {
  TestScene world;
  world.add_wall({12, -50, -50}, {12, 50, -50}, {12, 50, 50}, {12, -50, 50});
  for (const double x : {10.0, 14.0}) {
    SweepScene scene(std::make_shared<const StaticScene>(world.scene()), {point(), plate(), plate()}, 0,
                     Pose::Identity(), 100.0);
    StateHistory history(3, 10);
    history.push(0, at_rest({0, 0, 0}, 0));
    history.push(1, at_rest({x, 0, 0}, 0));
    history.push(2, at_rest({x - 0.5, 0, 0}, 0));
    scene.set_firings(firings_every(0.0));
    scene.begin(history, 0, 0);
    PacketHits hits;
    scene.trace(all_along(Eigen::Vector3f::UnitX()), false, hits);
    EXPECT_NEAR(hits.range_m[0], std::min(12.0, x - 0.5), 1e-5);
    EXPECT_EQ(scene.surfaces()[hits.surface[0]].vehicle, x < 12.0 ? 2 : kNoVehicle);
  }
}

TEST(SweepScene, MeetsRotorBladesAtEachInstant) {
  const auto shape = rotor_only();
  const VehicleShape::RotorShape& rotor = shape->rotors[0];
  SweepScene scene(nothing(), {point(), shape}, 0, Pose::Identity(), 100.0);
  // The sensor is 5 m below the rotor and looks up.
  const double speed_radps = 430.0;
  StateHistory history(2, 300);
  for (TimeNs t = 0; t <= 100 * kMs; t += kMs) {
    history.push(0, at_rest({0, 0, -5}, t));
    VehicleState target = at_rest({0, 0, 0}, t);
    target.rotor_speed_radps.fill(speed_radps);
    target.rotor_angle_rad.fill(1000.0 + speed_radps * to_seconds(t));
    history.push(1, target);
  }
  const Random random(2, "test.rotor");
  int num_inside = 0, num_met = 0;
  for (std::uint32_t k = 0; k < 4000; ++k) {
    std::vector<Firing> firings = firings_every(0.006);
    BeamPacket beams = all_along(Eigen::Vector3f::UnitZ());
    for (int i = 0; i < kPacketSize; ++i) {
      const auto index = static_cast<std::uint32_t>(kPacketSize * k + i);
      firings[i].offset_s = static_cast<float>(random.uniform(0, 0.1, 0, index));
      firings[i].origin_lidar_m = rotor.hub_body_m;
      firings[i].origin_lidar_m.x() += static_cast<float>(random.uniform(-0.3, 0.3, 1, index));
      firings[i].origin_lidar_m.y() += static_cast<float>(random.uniform(-0.3, 0.3, 2, index));
      firings[i].origin_lidar_m.z() = 0.0F;
    }
    scene.set_firings(firings);
    scene.begin(history, 0, 100 * kMs);
    PacketHits hits;
    scene.trace(beams, false, hits);
    for (int i = 0; i < kPacketSize; ++i) {
      const Eigen::Vector2f on_disc = (firings[i].origin_lidar_m - rotor.hub_body_m).head<2>();
      if (on_disc.norm() > rotor.radius_m) {
        EXPECT_EQ(hits.range_m[i], 0.0F);
        continue;
      }
      ++num_inside;
      if (hits.range_m[i] == 0.0F) continue;
      ++num_met;
      EXPECT_NEAR(hits.range_m[i], 5.05, 1e-4);
      EXPECT_EQ(scene.surfaces()[hits.surface[i]].part, VehiclePart::kRotor);
      // A blade is there: it covers the point, within the interpolation tolerance of its angle.
      const double angle = 1000.0 + speed_radps * firings[i].offset_s;
      bool covered = false;
      for (const double turn : {-2e-3, 0.0, 2e-3}) {
        covered |= VehicleShape::blade_covers(rotor, on_disc.x(), on_disc.y(), angle + turn);
      }
      EXPECT_TRUE(covered);
    }
  }
  // Share of hits = solidity, the area of the blades over that of the disc, here by a fine grid.
  int grid_inside = 0, grid_covered = 0;
  for (float x = -0.3F; x <= 0.3F; x += 0.001F) {
    for (float y = -0.3F; y <= 0.3F; y += 0.001F) {
      if (x * x + y * y > 0.09F) continue;
      ++grid_inside;
      grid_covered += VehicleShape::blade_covers(rotor, x, y, 0.0) ? 1 : 0;
    }
  }
  const double solidity = static_cast<double>(grid_covered) / grid_inside;
  EXPECT_GT(solidity, 0.02);
  EXPECT_NEAR(static_cast<double>(num_met) / num_inside, solidity,
              5.0 * std::sqrt(solidity * (1 - solidity) / num_inside));
}

TEST(SweepScene, TestsOwnRotorDiscsThenBlades) {
  const auto shape = rotor_only();
  SweepScene scene(nothing(), {shape}, 0, make_pose({0.2, 0.25, 1.0}, Eigen::Quaterniond::Identity()), 100.0);
  StateHistory history(1, 300);
  for (TimeNs t = 0; t <= 100 * kMs; t += kMs) {
    VehicleState state = at_rest({3, 4, 5}, t);
    state.rotor_speed_radps.fill(300.0);
    state.rotor_angle_rad.fill(300.0 * to_seconds(t));
    history.push(0, state);
  }
  scene.set_firings(firings_every(0.00625));
  const BeamPacket down = all_along(-Eigen::Vector3f::UnitZ());
  EXPECT_EQ(scene.reaches_self(down), 0xFFFFU);
  EXPECT_EQ(scene.reaches_self(all_along(Eigen::Vector3f::UnitZ())), 0U);
  EXPECT_EQ(scene.reaches_self(all_along(Eigen::Vector3f::UnitX())), 0U);
  scene.begin(history, 0, 100 * kMs);
  PacketHits hits;
  scene.trace(down, true, hits);
  for (int i = 0; i < kPacketSize; ++i) {
    const bool covered = VehicleShape::blade_covers(shape->rotors[0], 0.0F, 0.15F, 300.0 * 0.00625 * i);
    EXPECT_EQ(hits.range_m[i] > 0.0F, covered) << i;
    EXPECT_NEAR(hits.range_m[i], covered ? 0.95 : 0.0, 1e-5);
  }
}

TEST(SweepScene, SeesThroughHousingFromAboardOnly) {
  auto shape = std::make_shared<VehicleShape>(*plate());
  shape->meshes[0].part = VehiclePart::kSensor;
  SweepScene scene(nothing(), {shape, shape}, 0, make_pose({-0.2, 0, 0}, Eigen::Quaterniond::Identity()), 100.0);
  StateHistory history(2, 2);
  history.push(0, at_rest({0, 0, 0}, 0));
  history.push(1, at_rest({7, 0, 0}, 0));
  scene.set_firings(firings_every(0.0));
  scene.begin(history, 0, 0);
  PacketHits hits;
  const BeamPacket ahead = all_along(Eigen::Vector3f::UnitX());
  EXPECT_EQ(scene.reaches_self(ahead), 0U);
  scene.trace(ahead, true, hits);
  EXPECT_NEAR(hits.range_m[0], 7.2, 1e-5);
}

}  // namespace
}  // namespace swiftlet::sim
