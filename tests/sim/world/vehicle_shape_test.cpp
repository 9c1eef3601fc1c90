// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/vehicle_shape.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

Airframe make_airframe(int num_rotors, double arm_m) {
  Airframe airframe;
  airframe.arm_length_m = arm_m;
  for (int i = 0; i < num_rotors; ++i) {
    const double angle_rad = 2.0 * kPi * (i + 0.5) / num_rotors;
    Rotor rotor;
    rotor.position_m = {arm_m * std::cos(angle_rad), arm_m * std::sin(angle_rad), 0.03};
    rotor.spin = i % 2 == 0 ? Rotor::Spin::kCcw : Rotor::Spin::kCw;
    airframe.rotors.push_back(rotor);
  }
  return airframe;
}

TEST(VehicleShape, HasEveryPartWithinTriangleBudget) {
  for (const int num_rotors : {4, 6, 8}) {
    const VehicleShape shape = make_vehicle_shape(make_airframe(num_rotors, 0.3));
    std::map<VehiclePart, std::size_t> triangles;
    std::size_t sum = 0;
    for (const Mesh& mesh : shape.meshes) {
      EXPECT_EQ(mesh.surface_class, SurfaceClass::kVehicle);
      EXPECT_LT(mesh.material, shape.materials.size());
      EXPECT_GT(signed_volume_m3(mesh), 0.0) << name_of(mesh.part);
      triangles[mesh.part] += mesh.triangles.size();
      sum += mesh.triangles.size();
    }
    for (const VehiclePart part :
         {VehiclePart::kBody, VehiclePart::kArm, VehiclePart::kMotor, VehiclePart::kLeg, VehiclePart::kSensor}) {
      EXPECT_GT(triangles[part], 0U) << name_of(part);
    }
    EXPECT_EQ(triangles.count(VehiclePart::kRotor), 0U);
    EXPECT_LE(sum, 2500U) << "LiDARs trace every vehicle";
  }
}

TEST(VehicleShape, HasRotorsAsTheAirframeSpecifies) {
  const Airframe airframe = make_airframe(4, 0.25);
  const VehicleShape shape = make_vehicle_shape(airframe);
  ASSERT_EQ(shape.rotors.size(), 4U);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(shape.rotors[i].hub_body_m, airframe.rotors[i].position_m.cast<float>());
    EXPECT_EQ(shape.rotors[i].radius_m, static_cast<float>(airframe.propeller_radius_m));
    EXPECT_EQ(shape.rotors[i].direction, i % 2 == 0 ? 1.0F : -1.0F);
  }
}

TEST(VehicleShape, StaysWithinItsCircumscribedSphere) {
  const Airframe airframe = make_airframe(4, 0.325);
  const VehicleShape shape = make_vehicle_shape(airframe);
  for (const Mesh& mesh : shape.meshes) {
    for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m)
      EXPECT_LE(vertex.norm(), shape.circumscribed_radius_m + 1e-5F);
    if (mesh.part != VehiclePart::kArm && mesh.part != VehiclePart::kMotor) continue;
    for (const VehicleShape::RotorShape& rotor : shape.rotors) {
      float nearest = 1e9F;
      for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m)
        nearest = std::min(nearest, (vertex - rotor.hub_body_m).head<2>().norm());
      EXPECT_LT(nearest, 0.06F) << name_of(mesh.part);
    }
  }
  EXPECT_GE(shape.circumscribed_radius_m, static_cast<float>(airframe.circumscribed_radius_m()) - 1e-5F);
}

TEST(VehicleShape, AddsReflectiveMarkersToLegsOnly) {
  const Airframe airframe = make_airframe(4, 0.25);
  const VehicleShape plain = make_vehicle_shape(airframe);
  const MarkersConfig markers{.place = MarkersConfig::Place::kLegs, .reflectivity = 0.8};
  const VehicleShape marked = make_vehicle_shape(airframe, markers);
  ASSERT_EQ(marked.materials.size(), plain.materials.size() + 1);
  ASSERT_EQ(marked.meshes.size(), plain.meshes.size() + 1);
  EXPECT_EQ(marked.circumscribed_radius_m, plain.circumscribed_radius_m);
  for (const Mesh& mesh : marked.meshes) {
    const Material& material = marked.materials[mesh.material];
    EXPECT_EQ(material.retroreflective, mesh.part == VehiclePart::kMarker);
    if (mesh.part != VehiclePart::kMarker) continue;
    EXPECT_EQ(material.reflectivity, 0.8F);
    EXPECT_NEAR(signed_volume_m3(mesh), 4 * 0.08 * kPi * 0.015 * 0.015, 1e-6);
    EXPECT_GT(bounds_m(mesh).min().z(), -airframe.leg_height_m);
  }
}

TEST(VehicleShape, StandsAtTheAirframeHeight) {
  Airframe airframe = make_airframe(4, 0.25);
  airframe.leg_height_m = 0.23;
  float lowest_m = 0.0F;
  for (const Mesh& mesh : make_vehicle_shape(airframe).meshes) lowest_m = std::min(lowest_m, bounds_m(mesh).min().z());
  EXPECT_NEAR(lowest_m, -0.23F, 0.002F);
}

TEST(VehicleShape, BladesTurnWithTheAngle) {
  VehicleShape::RotorShape rotor;
  rotor.radius_m = 0.2F;
  rotor.chord_m = 0.02F;
  EXPECT_TRUE(VehicleShape::blade_covers(rotor, 0.1F, 0.0F, 0.0));
  EXPECT_TRUE(VehicleShape::blade_covers(rotor, -0.1F, 0.0F, 0.0));
  EXPECT_FALSE(VehicleShape::blade_covers(rotor, 0.0F, 0.1F, 0.0));
  EXPECT_TRUE(VehicleShape::blade_covers(rotor, 0.0F, 0.1F, kPi / 2));
  EXPECT_TRUE(VehicleShape::blade_covers(rotor, 0.0F, 0.1F, kPi / 2 - 2000 * kPi));
  EXPECT_FALSE(VehicleShape::blade_covers(rotor, 0.21F, 0.0F, 0.0));  // beyond the tip
  EXPECT_FALSE(VehicleShape::blade_covers(rotor, 0.01F, 0.0F, 0.0));  // at the hub
}

TEST(VehicleShape, MatchesAirframeRadiusAndHeight) {
  for (const double height_m : {0.05, 0.1, 0.3}) {
    Airframe airframe = make_airframe(4, 0.4);
    airframe.body_height_m = height_m;
    airframe.body_radius_m = 0.17;
    for (const Mesh& mesh : make_vehicle_shape(airframe).meshes) {
      if (mesh.part != VehiclePart::kBody) continue;
      float radius_m = 0.0F;
      for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) radius_m = std::max(radius_m, vertex.head<2>().norm());
      EXPECT_NEAR(radius_m, 0.17F, 0.03F * 0.17F);
      EXPECT_NEAR(bounds_m(mesh).sizes().z(), height_m, 0.2 * height_m);
    }
  }
}

}  // namespace
}  // namespace swiftlet::sim
