// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/sim/world/foliage.hpp"

namespace swiftlet::sim {

/// Truth class of a surface. The numbers are the labels in datasets (docs/conventions.md). Where SemanticKITTI uses a
/// number for a different class, the class here is 300 higher than the group to which it belongs.
enum class SurfaceClass : std::uint16_t {
  kUnlabeled = 0,
  kGround = 40,
  kKerb = 48,
  kBuilding = 50,
  kWall = 351,
  kDoor = 352,
  kPillar = 53,
  kCeiling = 54,
  kVegetation = 70,  // leaves, crowns
  kTrunk = 71,
  kBranch = 372,
  kUndergrowth = 73,
  kFallenTrunk = 74,
  kRack = 380,
  kPallet = 381,
  kMarking = 82,  // reflective tape, signs
  kObject = 99,
  kVehicle = 300,  // a UAV
};

/// Lower-case name of a class ("trunk"), as written in truth tables.
const char* name_of(SurfaceClass surface_class);
/// The class of this name; kVehicle is not accepted because the static world has no vehicles.
std::optional<SurfaceClass> surface_class_of(std::string_view name);
std::span<const char* const> static_class_names();

/// Part of a vehicle to which a triangle belongs; kNone for the static world.
enum class VehiclePart : std::uint8_t { kNone = 0, kBody, kArm, kMotor, kRotor, kLeg, kSensor, kMarker };
const char* name_of(VehiclePart part);

struct Material {
  std::string name;
  float reflectivity = 0.3F;                       ///< Lambertian, at the LiDAR's wavelength (865..905 nm), 0..1
  bool retroreflective = false;                    ///< returns the beam to its source at any incidence angle
  Eigen::Vector3f color_rgb = {0.5F, 0.5F, 0.5F};  ///< for pictures, sRGB 0..1
};

/// Triangles of one material. Counter-clockwise seen from outside; LiDAR and contacts treat them as two-sided.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices_mesh_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::uint32_t material = 0;  ///< index in Scene::materials
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  VehiclePart part = VehiclePart::kNone;  ///< only for meshes of vehicles
};

/// One object of the static world: meshes share a truth instance number (a tree = trunk + branches + crown).
struct Instance {
  std::uint32_t mesh = 0;  ///< index in Scene::meshes
  Eigen::Affine3f T_world_mesh = Eigen::Affine3f::Identity();
  std::uint16_t instance = 0;  ///< truth instance within its class; 0: none (ground)
};

/// Connected components of the triangles by shared vertices: for each vertex the least vertex index of its component.
/// @param welded  for each vertex the representative of coinciding vertices; empty: each vertex itself
std::vector<std::uint32_t> pieces_of(const Mesh& mesh, std::span<const std::uint32_t> welded = {});

/// Truth about one object, for `swiftlet world` tables and metrics (for forests: the stem map).
struct WorldObject {
  std::uint16_t instance = 0;
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  std::string kind;                                            ///< "pine", "rack", ...
  Eigen::Vector3d position_world_m = Eigen::Vector3d::Zero();  ///< foot of a stem, center of any other object
  double yaw_rad = 0.0;
  /// Such as {"dbh_m", 0.31}, {"height_m", 18.2}; equal keys for equal kinds
  std::vector<std::pair<std::string, double>> attributes;
};

/// The static world: a pure function of (config, seed). World frame: east, north, up. Leaves are at their rest
/// positions.
struct Scene {
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  std::vector<WorldObject> objects;
  FoliageConfig foliage;           ///< wind motion of leaves: meshes of SurfaceClass::kVegetation
  std::uint64_t foliage_seed = 0;  ///< seed of the leaves' motion
  /// Extent of the scene; surroundings that only fill the view contribute their height alone
  Eigen::AlignedBox3d bounds_m;
  std::vector<Counter> counters;  ///< parts of an input file that were omitted; settings by their path in the scenario

  std::size_t num_triangles() const;  ///< counts instanced meshes as often as they are placed
};

}  // namespace swiftlet::sim
