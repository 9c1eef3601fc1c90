// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/airframe.hpp"
#include "swiftlet/sim/world/markers.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Shape of a vehicle, built from its airframe: body, arms, motors, legs, sensors; body frame. Rotors are separate
/// because they spin.
struct VehicleShape {
  struct RotorShape {
    Eigen::Vector3f hub_body_m = Eigen::Vector3f::Zero();
    float radius_m = 0.1F;
    int blades = 2;
    float chord_m = 0.02F;   ///< width of a blade
    float direction = 1.0F;  ///< +1 ccw seen from above
  };

  std::vector<Material> materials;  ///< index 0: frame, 1: rotor, 2: sensor, 3: markers, if any
  std::vector<Mesh> meshes;         ///< everything except the rotors; `part` is set
  std::vector<RotorShape> rotors;
  std::uint32_t rotor_material = 1;
  float circumscribed_radius_m = 0.5F;

  /// True if the blade of a rotor at `angle_rad` covers the point (x, y) [m] of its disc, with the hub at the origin.
  static bool blade_covers(const RotorShape& rotor, float x, float y, double angle_rad);
};

VehicleShape make_vehicle_shape(const Airframe& airframe, const MarkersConfig& markers = {});

}  // namespace swiftlet::sim
