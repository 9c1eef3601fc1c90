// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/vehicle_shape.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3f;

enum MaterialIndex : std::uint32_t { kFrame = 0, kRotorBlade = 1, kSensorHousing = 2, kMarker = 3 };

// [-] Sides of round parts.
constexpr int kRoundSides = 16;
constexpr float kRootCutout = 0.12F;  // start of the blade, as a share of the radius
constexpr float kTipTaper = 0.45F;    // chord at the tip / largest chord

Mesh& part_of(VehicleShape& shape, VehiclePart part, std::uint32_t material) {
  for (Mesh& mesh : shape.meshes) {
    if (mesh.part == part) return mesh;
  }
  Mesh mesh;
  mesh.material = material;
  mesh.surface_class = SurfaceClass::kVehicle;
  mesh.part = part;
  shape.meshes.push_back(std::move(mesh));
  return shape.meshes.back();
}

void add_upright(Mesh& mesh, const Vector3f& foot_m, float radius_m, float height_m) {
  add_frustum(mesh, foot_m, radius_m, foot_m + Vector3f(0, 0, height_m), radius_m, kRoundSides);
}

// Two plates with avionics between them and the battery below.
void add_body(VehicleShape& shape, const Airframe& airframe, float arm_z_m) {
  const auto radius_m = static_cast<float>(airframe.body_radius_m);
  const auto height_m = static_cast<float>(airframe.body_height_m);
  const float plate_m = std::max(0.003F, 0.04F * height_m);
  Mesh& body = part_of(shape, VehiclePart::kBody, kFrame);
  add_upright(body, {0, 0, arm_z_m - 0.25F * height_m - plate_m}, radius_m, plate_m);
  add_upright(body, {0, 0, arm_z_m + 0.25F * height_m}, radius_m, plate_m);
  add_box(body, Vector3f(-0.6F * radius_m, -0.4F * radius_m, arm_z_m - 0.25F * height_m),
          Vector3f(0.6F * radius_m, 0.4F * radius_m, arm_z_m + 0.25F * height_m));
  add_box(body, Vector3f(-0.75F * radius_m, -0.3F * radius_m, arm_z_m - 0.6F * height_m),
          Vector3f(0.75F * radius_m, 0.3F * radius_m, arm_z_m - 0.25F * height_m - plate_m));
  for (int i = 0; i < 4; ++i) {  // spacers between the plates
    const float angle_rad = std::numbers::pi_v<float> * (0.5F * static_cast<float>(i));
    add_upright(body,
                {0.8F * radius_m * elementary::cos(angle_rad), 0.8F * radius_m * elementary::sin(angle_rad),
                 arm_z_m - 0.25F * height_m},
                0.03F * radius_m, 0.5F * height_m);
  }
}

// A tube from the plates to below the hub, with the motor at its end.
void add_arm(VehicleShape& shape, const Airframe& airframe, const Vector3f& hub_m, float arm_z_m) {
  const auto arm_length_m = static_cast<float>(airframe.arm_length_m);
  const auto blade_m = static_cast<float>(airframe.propeller_radius_m);
  const float tube_m = std::clamp(0.04F * arm_length_m, 0.006F, 0.02F);
  const float motor_radius_m = std::clamp(0.11F * blade_m, 0.010F, 0.045F);
  const Vector3f end_m(hub_m.x(), hub_m.y(), arm_z_m);
  const Vector3f outward =
      end_m.head<2>().norm() > 1e-3F ? Vector3f(end_m.x(), end_m.y(), 0).normalized() : Vector3f::UnitX();
  const Vector3f start_m = Vector3f(0, 0, arm_z_m) + 0.5F * static_cast<float>(airframe.body_radius_m) * outward;
  add_frustum(part_of(shape, VehiclePart::kArm, kFrame), start_m, tube_m, end_m + motor_radius_m * outward, tube_m, 10);

  Mesh& motor = part_of(shape, VehiclePart::kMotor, kFrame);
  const float foot_z_m = std::min(arm_z_m - tube_m, hub_m.z() - 0.5F * motor_radius_m);
  add_upright(motor, {hub_m.x(), hub_m.y(), foot_z_m}, motor_radius_m, hub_m.z() - foot_z_m);
  add_upright(motor, hub_m, 0.25F * motor_radius_m, 0.35F * motor_radius_m);  // shaft and propeller nut
}

// A sleeve around the middle of a strut, at most four fifths of its length.
void add_sleeve(VehicleShape& shape, const MarkersConfig& markers, const Vector3f& top_m, const Vector3f& foot_m) {
  const Vector3f middle_m = 0.5F * (top_m + foot_m), along_m = foot_m - top_m;
  const float half = 0.5F * std::min(static_cast<float>(markers.length_m) / along_m.norm(), 0.8F);
  const float radius_m = 0.5F * static_cast<float>(markers.width_m);
  add_frustum(part_of(shape, VehiclePart::kMarker, kMarker), middle_m - half * along_m, radius_m,
              middle_m + half * along_m, radius_m, 12);
}

// Two skids on four struts, with a sleeve in the middle of each strut.
void add_legs(VehicleShape& shape, const Airframe& airframe, const MarkersConfig& markers, float arm_z_m) {
  const auto radius_m = static_cast<float>(airframe.body_radius_m);
  const auto height_m = static_cast<float>(airframe.body_height_m);
  const float tube_m = std::clamp(0.02F * static_cast<float>(airframe.arm_length_m), 0.004F, 0.012F);
  // Height at which contacts support the vehicle
  const float foot_z_m = tube_m - static_cast<float>(airframe.leg_height_m);
  Mesh& legs = part_of(shape, VehiclePart::kLeg, kFrame);
  for (const float side : {-1.0F, 1.0F}) {
    for (const float end : {-0.7F, 0.7F}) {
      add_frustum(legs, {end * radius_m, 0.5F * side * radius_m, arm_z_m - 0.25F * height_m}, tube_m,
                  {end * radius_m, 1.3F * side * radius_m, foot_z_m}, tube_m, 8);
    }
    add_frustum(legs, {-1.5F * radius_m, 1.3F * side * radius_m, foot_z_m}, tube_m,
                {1.5F * radius_m, 1.3F * side * radius_m, foot_z_m}, tube_m, 8);
  }
  if (markers.place == MarkersConfig::Place::kNone) return;
  for (const float side : {-1.0F, 1.0F}) {
    for (const float end : {-0.7F, 0.7F}) {
      add_sleeve(shape, markers, {end * radius_m, 0.5F * side * radius_m, arm_z_m - 0.25F * height_m},
                 {end * radius_m, 1.3F * side * radius_m, foot_z_m});
    }
  }
}

// A round housing on a short mast, like a spinning LiDAR or a GNSS antenna.
void add_sensor(VehicleShape& shape, const Airframe& airframe, float arm_z_m) {
  const auto body_radius_m = static_cast<float>(airframe.body_radius_m);
  const auto height_m = static_cast<float>(airframe.body_height_m);
  const float puck_radius_m = std::clamp(0.35F * body_radius_m, 0.02F, 0.0435F);  // an OS1 has a diameter of 87 mm
  const float top_m = arm_z_m + 0.3F * height_m;
  Mesh& sensor = part_of(shape, VehiclePart::kSensor, kSensorHousing);
  add_upright(sensor, {0, 0, top_m}, 0.5F * puck_radius_m, 0.1F * height_m);
  add_upright(sensor, {0, 0, top_m + 0.1F * height_m}, puck_radius_m, 1.6F * puck_radius_m);
}

float reach_m(const VehicleShape& shape) {
  float reach = 0.0F;
  for (const Mesh& mesh : shape.meshes) {
    for (const Vector3f& vertex : mesh.vertices_mesh_m) reach = std::max(reach, vertex.norm());
  }
  for (const VehicleShape::RotorShape& rotor : shape.rotors) {
    reach =
        std::max(reach, elementary::hypot(rotor.hub_body_m.head<2>().norm() + rotor.radius_m, rotor.hub_body_m.z()));
  }
  return reach;
}

}  // namespace

bool VehicleShape::blade_covers(const RotorShape& rotor, float x, float y, double angle_rad) {
  const float radius_sq = x * x + y * y;
  if (radius_sq > rotor.radius_m * rotor.radius_m) return false;
  // Rotates the point into the frame of the rotor and then to its nearest blade, which lies along +x.
  const double pitch_rad = 2.0 * std::numbers::pi / rotor.blades;
  const double from_blade_0_rad = elementary::atan2(y, x) - angle_rad;
  const double from_blade_rad = from_blade_0_rad - pitch_rad * std::round(from_blade_0_rad / pitch_rad);
  const float radius = std::sqrt(radius_sq);
  const auto along = static_cast<float>(radius * elementary::cos(from_blade_rad));
  const auto across = static_cast<float>(radius * elementary::sin(from_blade_rad));
  const float root_m = kRootCutout * rotor.radius_m;
  if (along < root_m) return false;
  const float taper = (along - root_m) / (rotor.radius_m - root_m);
  const float chord_m = rotor.chord_m * (1.0F + (kTipTaper - 1.0F) * taper);
  return std::abs(across) <= 0.5F * chord_m;
}

void MarkersConfig::visit(ConfigVisitor& v) {
  v.choice("place", place, {"none", "legs"}, "[-] positions of retro-reflective sleeves: none, or on each leg");
  v.field("length_m", length_m, "[m] length of a sleeve along its leg, at most four fifths of the leg",
          Range::between(0.001, 1.0));
  v.field("width_m", width_m, "[m] width of a sleeve", Range::between(0.001, 0.1));
  v.field("reflectivity", reflectivity,
          "[-] reflectivity of the foil at the LiDAR's wavelength; multiplied by the LiDAR's detection.retro_gain",
          Range::probability());
}

VehicleShape make_vehicle_shape(const Airframe& airframe, const MarkersConfig& markers) {
  VehicleShape shape;
  const auto reflectivity = static_cast<float>(airframe.reflectivity);
  shape.materials = {{"frame", reflectivity, false, {0.13F, 0.13F, 0.15F}},
                     {"rotor", 0.10F, false, {0.22F, 0.22F, 0.24F}},    // black plastic or carbon fiber
                     {"sensor", 0.25F, false, {0.55F, 0.57F, 0.60F}}};  // anodized aluminum
  if (markers.place != MarkersConfig::Place::kNone) {
    shape.materials.push_back({"marker", static_cast<float>(markers.reflectivity), true, {0.95F, 0.93F, 0.35F}});
  }

  // The arms lie below the hubs, at the height of the plates.
  float hub_z_m = 0.0F;
  for (const Rotor& rotor : airframe.rotors)
    hub_z_m += static_cast<float>(rotor.position_m.z()) / airframe.num_rotors();
  const float motor_height_m = std::clamp(0.2F * static_cast<float>(airframe.propeller_radius_m), 0.015F, 0.06F);
  const float arm_z_m = hub_z_m - motor_height_m;

  add_body(shape, airframe, arm_z_m);
  for (const Rotor& rotor : airframe.rotors) add_arm(shape, airframe, rotor.position_m.cast<float>(), arm_z_m);
  add_legs(shape, airframe, markers, arm_z_m);
  add_sensor(shape, airframe, arm_z_m);
  for (const Rotor& rotor : airframe.rotors) {
    const auto radius_m = static_cast<float>(airframe.propeller_radius_m);
    shape.rotors.push_back({rotor.position_m.cast<float>(), radius_m, airframe.propeller_blades, 0.16F * radius_m,
                            static_cast<float>(rotor.direction())});
  }
  shape.rotor_material = kRotorBlade;
  shape.circumscribed_radius_m = reach_m(shape);
  return shape;
}

}  // namespace swiftlet::sim
