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

#include "swiftlet/core/counter.hpp"
#include "swiftlet/sim/world/foliage.hpp"

namespace swiftlet::sim {

/// Truth class of a surface. The numbers are the labels in datasets (docs/conventions.md). A number that SemanticKITTI
/// gives to another thing is not used: such classes lie 300 higher than the group they belong to.
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
/// The same names back; every class but kVehicle can be asked for (the static world has no vehicles).
std::optional<SurfaceClass> surface_class_of(std::string_view name);
std::span<const char* const> static_class_names();

/// Which part of a vehicle a triangle belongs to; kNone for the static world.
enum class VehiclePart : std::uint8_t { kNone = 0, kBody, kArm, kMotor, kRotor, kLeg, kSensor, kMarker };
const char* name_of(VehiclePart part);

struct Material {
  std::string name;
  float reflectivity = 0.3F;                       ///< Lambertian, at the LiDAR's wavelength (865..905 nm), 0..1
  bool retroreflective = false;                    ///< returns the beam to its source whatever the incidence
  Eigen::Vector3f color_rgb = {0.5F, 0.5F, 0.5F};  ///< for pictures, sRGB 0..1
};

/// Triangles of one material. Counter-clockwise seen from outside; LiDAR and contacts treat them as two-sided.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices_mesh_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::uint32_t material = 0;  ///< index in Scene::materials
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  VehiclePart part = VehiclePart::kNone;  ///< vehicles' meshes only
};

/// One thing of the static world: meshes share a truth instance number (a tree = trunk + branches + crown).
struct Instance {
  std::uint32_t mesh = 0;  ///< index in Scene::meshes
  Eigen::Affine3f T_world_mesh = Eigen::Affine3f::Identity();
  std::uint16_t instance = 0;  ///< truth instance within its class; 0: none (ground)
};

/// Triangles that hang together by their vertices: the number of the piece for each vertex, which is its least vertex.
/// @param welded  for each vertex the one that stands for it; empty: itself
std::vector<std::uint32_t> pieces_of(const Mesh& mesh, std::span<const std::uint32_t> welded = {});

/// Truth about one thing, for `swiftlet world` tables and metrics (for forests: the stem map).
struct WorldObject {
  std::uint16_t instance = 0;
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  std::string kind;                                            ///< "pine", "rack", ...
  Eigen::Vector3d position_world_m = Eigen::Vector3d::Zero();  ///< foot of a stem, center of anything else
  double yaw_rad = 0.0;
  std::vector<std::pair<std::string, double>>
      attributes;  ///< such as {"dbh_m", 0.31}, {"height_m", 18.2}; same keys for the same kind
};

/// The static world: a pure function of (config, seed). World frame: east, north, up. Leaves are where they hang.
struct Scene {
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  std::vector<WorldObject> objects;
  FoliageConfig foliage;           ///< of the leaves of crowns, meshes of SurfaceClass::kVegetation
  std::uint64_t foliage_seed = 0;  ///< of their motion
  Eigen::AlignedBox3d bounds_m;    ///< of the place: surroundings that only fill the view count for the height alone
  std::vector<Counter> counters;   ///< what of a file was left out; settings by their path in the scenario

  std::size_t num_triangles() const;  ///< with instancing unrolled
};

}  // namespace swiftlet::sim
