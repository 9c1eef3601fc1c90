// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

const char* name_of(SurfaceClass surface_class) {
  switch (surface_class) {
    case SurfaceClass::kUnlabeled:
      return "unlabeled";
    case SurfaceClass::kGround:
      return "ground";
    case SurfaceClass::kKerb:
      return "kerb";
    case SurfaceClass::kBuilding:
      return "building";
    case SurfaceClass::kWall:
      return "wall";
    case SurfaceClass::kDoor:
      return "door";
    case SurfaceClass::kPillar:
      return "pillar";
    case SurfaceClass::kCeiling:
      return "ceiling";
    case SurfaceClass::kVegetation:
      return "vegetation";
    case SurfaceClass::kTrunk:
      return "trunk";
    case SurfaceClass::kBranch:
      return "branch";
    case SurfaceClass::kUndergrowth:
      return "undergrowth";
    case SurfaceClass::kFallenTrunk:
      return "fallen_trunk";
    case SurfaceClass::kRack:
      return "rack";
    case SurfaceClass::kPallet:
      return "pallet";
    case SurfaceClass::kMarking:
      return "marking";
    case SurfaceClass::kObject:
      return "object";
    case SurfaceClass::kVehicle:
      return "vehicle";
  }
  return "unlabeled";
}

std::span<const char* const> static_class_names() {
  using enum SurfaceClass;
  static const std::array kNames = {name_of(kUnlabeled),   name_of(kGround), name_of(kKerb),   name_of(kBuilding),
                                    name_of(kWall),        name_of(kDoor),   name_of(kPillar), name_of(kCeiling),
                                    name_of(kVegetation),  name_of(kTrunk),  name_of(kBranch), name_of(kUndergrowth),
                                    name_of(kFallenTrunk), name_of(kRack),   name_of(kPallet), name_of(kMarking),
                                    name_of(kObject)};
  return kNames;
}

std::optional<SurfaceClass> surface_class_of(std::string_view name) {
  using enum SurfaceClass;
  for (const SurfaceClass candidate :
       {kUnlabeled, kGround, kKerb, kBuilding, kWall, kDoor, kPillar, kCeiling, kVegetation, kTrunk, kBranch,
        kUndergrowth, kFallenTrunk, kRack, kPallet, kMarking, kObject}) {
    if (name == name_of(candidate)) return candidate;
  }
  return std::nullopt;
}

const char* name_of(VehiclePart part) {
  switch (part) {
    case VehiclePart::kNone:
      return "none";
    case VehiclePart::kBody:
      return "body";
    case VehiclePart::kArm:
      return "arm";
    case VehiclePart::kMotor:
      return "motor";
    case VehiclePart::kRotor:
      return "rotor";
    case VehiclePart::kLeg:
      return "leg";
    case VehiclePart::kSensor:
      return "sensor";
    case VehiclePart::kMarker:
      return "marker";
  }
  return "none";
}

std::size_t Scene::num_triangles() const {
  std::size_t count = 0;
  for (const Instance& instance : instances) count += meshes[instance.mesh].triangles.size();
  return count;
}

}  // namespace swiftlet::sim
