// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/scene.hpp"

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
  }
  return "none";
}

std::size_t Scene::num_triangles() const {
  std::size_t count = 0;
  for (const Instance& instance : instances) count += meshes[instance.mesh].triangles.size();
  return count;
}

}  // namespace swiftlet::sim
