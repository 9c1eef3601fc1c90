// SPDX-License-Identifier: BSD-3-Clause
// Hits of the beams of a sweep, against a search through all triangles and blades at the instant of each beam.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/raycast/sweep_scene.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

constexpr TimeNs kMillisecond = 1'000'000;

std::shared_ptr<const VehicleShape> six_rotors(double arm_m) {
  Airframe airframe;
  airframe.arm_length_m = arm_m;
  for (int i = 0; i < 6; ++i) {
    const double angle = (0.5 + i) * std::numbers::pi / 3.0;
    airframe.rotors.push_back({Vector3(arm_m * std::cos(angle), arm_m * std::sin(angle), 0.04),
                               i % 2 == 0 ? Rotor::Spin::kCcw : Rotor::Spin::kCw});
  }
  return std::make_shared<const VehicleShape>(make_vehicle_shape(airframe));
}

/// Flies a curve, banks and turns; its rotors turn faster and faster.
VehicleState flying(int vehicle, double t) {
  VehicleState state;
  const Vector3 middle_m[] = {{0, 0, 0}, {6, 1, 0.5}, {-4, 5, -1}, {0.5, -9, 2}, {33, 0, 0}};
  state.p_world_m =
      middle_m[vehicle] + Vector3(std::sin(2.0 * t + vehicle), std::cos(1.5 * t + vehicle), 0.3 * std::sin(3.0 * t));
  state.v_world_mps = {2.0 * std::cos(2.0 * t + vehicle), -1.5 * std::sin(1.5 * t + vehicle), 0.9 * std::cos(3.0 * t)};
  state.q_world_body = Eigen::AngleAxisd(0.7 * vehicle + 1.5 * t, Vector3::UnitZ()) *
                       Eigen::AngleAxisd(0.3 * std::sin(4.0 * t + vehicle), Vector3::UnitX());
  for (std::size_t r = 0; r < 6; ++r) {
    const double sign = r % 2 == 0 ? 1.0 : -1.0, rate = 200.0 + 40.0 * static_cast<double>(r);
    state.rotor_speed_radps[r] = rate + 2.0 * 300.0 * t;
    state.rotor_angle_rad[r] = 100.0 * static_cast<double>(r) + sign * (rate * t + 300.0 * t * t);
  }
  return state;
}

struct BruteHit {
  double range_m = 0.0, cosine = 0.0;
  VehicleId vehicle = kNoVehicle;
  VehiclePart part = VehiclePart::kNone;
  std::uint32_t material = 0;
  std::uint16_t instance = 0;
};

/// All arguments are in one frame.
void intersect_triangle(const Vector3& from_m, const Vector3& direction, const Vector3& a, const Vector3& b,
                        const Vector3& c, const BruteHit& surface, BruteHit& nearest) {
  const Vector3 n = (b - a).cross(c - a).normalized();
  const double range_m = n.dot(a - from_m) / n.dot(direction);
  if (!(range_m > 0.0) || range_m >= nearest.range_m) return;
  const Vector3 p = from_m + range_m * direction;
  if (n.dot((b - a).cross(p - a)) < 0.0 || n.dot((c - b).cross(p - b)) < 0.0 || n.dot((a - c).cross(p - c)) < 0.0)
    return;
  nearest = surface;
  nearest.range_m = range_m;
  nearest.cosine = std::abs(n.dot(direction));
}

void intersect_vehicle(const VehicleShape& shape, const VehicleState& state, VehicleId id, bool with_sensors,
                       const Vector3& from_world_m, const Vector3& direction_world, BruteHit& nearest) {
  const Pose T_body_world = state.T_world_body().inverse();
  const Vector3 from_m = T_body_world * from_world_m, direction = T_body_world.linear() * direction_world;
  if (from_m.cross(direction).norm() > 1.5) return;  // no vehicle is that large
  for (const Mesh& mesh : shape.meshes) {
    if (mesh.part == VehiclePart::kSensor && !with_sensors) continue;
    const auto corner = [&](std::uint32_t i) -> Vector3 { return mesh.vertices_mesh_m[i].cast<double>(); };
    const BruteHit surface{0.0, 0.0, id, mesh.part, mesh.material, static_cast<std::uint16_t>(id + 1)};
    for (const auto& t : mesh.triangles)
      intersect_triangle(from_m, direction, corner(t[0]), corner(t[1]), corner(t[2]), surface, nearest);
  }
  for (std::size_t r = 0; r < shape.rotors.size(); ++r) {
    const auto& rotor = shape.rotors[r];
    const double range_m = (rotor.hub_body_m.z() - from_m.z()) / direction.z();
    if (!(range_m > 0.0) || range_m >= nearest.range_m) continue;
    const Vector3 p = from_m + range_m * direction - rotor.hub_body_m.cast<double>();
    if (p.head<2>().norm() > rotor.radius_m) continue;
    if (!VehicleShape::blade_covers(rotor, static_cast<float>(p.x()), static_cast<float>(p.y()),
                                    state.rotor_angle_rad[r]))
      continue;
    nearest = {range_m,
               std::abs(direction.z()),
               id,
               VehiclePart::kRotor,
               shape.rotor_material,
               static_cast<std::uint16_t>(id + 1)};
  }
}

TEST(SweepDefinition, MatchesBruteForceOverAllTriangles) {
  TestScene world;
  world.add_box({-20, -20, -4}, {20, 20, 9}, SurfaceClass::kWall, 5, 0);
  world.add_box({4.5F, -2, -1}, {5, -1, 1}, SurfaceClass::kPillar, 6, world.add_material(0.5F));
  const auto scene = std::make_shared<const StaticScene>(world.scene());
  const std::vector<std::shared_ptr<const VehicleShape>> shapes = {six_rotors(0.3), six_rotors(0.5), six_rotors(0.3),
                                                                   six_rotors(0.8), six_rotors(0.4)};
  const Pose T_body_lidar =
      make_pose({0.05, 0.02, 0.2}, Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3(1, 2, 3).normalized())));
  const Random random(1, "test.sweep");
  for (const bool is_box : {true, false}) {
    for (const TimeNs duration : {100 * kMillisecond, 7 * kMillisecond, TimeNs{0}}) {
      SweepScene sweep(is_box ? scene : std::make_shared<const StaticScene>(Scene{}), shapes, 0, T_body_lidar, 30.0);
      StateHistory history(5, 300);
      const TimeNs start = 40 * kMillisecond;
      for (TimeNs t = 0; t <= 160 * kMillisecond; t += kMillisecond) {
        for (VehicleId i = 0; i < 5; ++i) {
          VehicleState state = flying(i, to_seconds(t));
          state.t = t;
          history.push(i, state);
        }
      }
      constexpr int kPackets = 60;
      std::vector<Firing> firings(kPackets * kPacketSize);
      for (std::uint32_t i = 0; i < firings.size(); ++i) {
        firings[i].offset_s = static_cast<float>(to_seconds(duration) * random.uniform(0, i));
        firings[i].origin_lidar_m = {static_cast<float>(0.03 * random.uniform(1, i)), 0.01F, 0.0F};
      }
      sweep.set_firings(firings, is_box);
      sweep.begin(history, start, duration);
      int on_vehicles = 0, on_rotors = 0, on_own = 0, different = 0, nothing = 0;
      for (std::uint32_t k = 0; k < kPackets; ++k) {
        BeamPacket beams;
        // Towards one of the vehicles, or down at the own one.
        const int target = static_cast<int>(k % 5);
        for (std::uint32_t i = 0; i < kPacketSize; ++i) {
          const auto number = static_cast<int>(kPacketSize * k + i);
          beams.firing[i] = number;
          const double t =
              to_seconds(start) + (duration == 0 ? 0.0 : firings[static_cast<std::size_t>(number)].offset_s);
          const VehicleState own = flying(0, t);
          const Pose T_world_lidar = own.T_world_body() * T_body_lidar;
          const auto n = random.normal3(k, i);
          const Vector3 aim_m =
              flying(target, t).p_world_m + (target == 0 ? 0.25 : 0.3) * Vector3(n[0], n[1], 0.4 * n[2]);
          const Vector3 from_m =
              T_world_lidar * firings[static_cast<std::size_t>(number)].origin_lidar_m.cast<double>();
          const Eigen::Vector3f direction =
              (T_world_lidar.linear().transpose() * (aim_m - from_m)).normalized().cast<float>();
          beams.direction_x[i] = direction.x(), beams.direction_y[i] = direction.y(),
          beams.direction_z[i] = direction.z();
        }
        PacketHits hits;
        sweep.trace(beams, true, hits);
        const std::uint32_t reaches = sweep.reaches_self(beams);
        for (std::uint32_t i = 0; i < kPacketSize; ++i) {
          const auto number = static_cast<std::size_t>(kPacketSize * k + i);
          const double t = to_seconds(start) + (duration == 0 ? 0.0 : firings[number].offset_s);
          const Pose T_world_lidar = flying(0, t).T_world_body() * T_body_lidar;
          EXPECT_LT((sweep.T_world_lidar(static_cast<int>(number)).matrix() - T_world_lidar.matrix()).norm(), 1e-4);
          const Vector3 from_m = T_world_lidar * firings[number].origin_lidar_m.cast<double>();
          const Vector3 direction =
              T_world_lidar.linear() * Vector3(beams.direction_x[i], beams.direction_y[i], beams.direction_z[i]);
          BruteHit brute;
          brute.range_m = 30.0;
          for (const Mesh& mesh : is_box ? world.scene().meshes : std::vector<Mesh>{}) {
            const auto corner = [&](std::uint32_t c) -> Vector3 { return mesh.vertices_mesh_m[c].cast<double>(); };
            const BruteHit surface{
                0.0,           0.0,
                kNoVehicle,    VehiclePart::kNone,
                mesh.material, static_cast<std::uint16_t>(mesh.surface_class == SurfaceClass::kWall ? 5 : 6)};
            for (const auto& c : mesh.triangles)
              intersect_triangle(from_m, direction, corner(c[0]), corner(c[1]), corner(c[2]), surface, brute);
          }
          for (VehicleId id = 0; id < 5; ++id)
            intersect_vehicle(*shapes[static_cast<std::size_t>(id)], flying(id, t), id, id != 0, from_m, direction,
                              brute);
          const bool is_hit = brute.range_m < 30.0;
          nothing += !is_hit;
          const SweepSurface& surface = sweep.surfaces()[hits.surface[i]];
          const bool same = is_hit == (hits.range_m[i] > 0.0F) &&
                            (!is_hit || (std::abs(hits.range_m[i] - brute.range_m) < 1e-3 &&
                                         surface.vehicle == brute.vehicle && surface.part == brute.part &&
                                         surface.material == brute.material && surface.instance == brute.instance &&
                                         std::abs(hits.cos_incidence[i] - brute.cosine) < 2e-3));
          different += !same;
          if (!same) continue;
          on_vehicles += brute.vehicle != kNoVehicle;
          on_rotors += brute.part == VehiclePart::kRotor;
          on_own += brute.vehicle == 0;
          EXPECT_TRUE(brute.vehicle != 0 || (reaches >> i & 1U) != 0);
        }
      }
      EXPECT_GT(on_vehicles, 200);
      EXPECT_GT(on_rotors, 3);
      EXPECT_GT(on_own, 40);
      EXPECT_EQ(nothing > 0, !is_box);
      EXPECT_LT(different, kPackets * kPacketSize / 60) << "rounding decides at edges only";
    }
  }
}

}  // namespace
}  // namespace swiftlet::sim
