// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sim/render/cameras.hpp"
#include "sim/render/gl_objects_internal.hpp"
#include "sim/render/wide_lines.hpp"
#include "sim/render/world_painter.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {

/// GPU representation of the vehicles: bodies in their colors, blades at their true angles.
class VehiclePainter {
 public:
  VehiclePainter(const GlFunctions& gl, std::span<const std::shared_ptr<const VehicleShape>> shapes);

  /// Draws bodies and blades with the current program (mesh, depth or ghost), whose uniforms must be set.
  void draw(std::span<const VehicleState> states, double scale, VehicleId hidden) const;
  /// As draw(), for one vehicle.
  void draw_one(std::size_t vehicle, const VehicleState& state, double scale) const;
  /// Appends translucent discs of spinning rotors, as triangles for the blending pass, from far to near.
  void append_discs(const View& view, std::span<const VehicleState> states, double scale, VehicleId hidden,
                    std::vector<ClipVertex>& out) const;

 private:
  struct Part {
    GLsizei first_index = 0;
    GLsizei num_indices = 0;
    Eigen::Vector4f color;  // linear color, and the SurfaceKind
  };
  struct PlacedRotor {
    VehicleShape::RotorShape shape;
    Part blades;  // at angle 0, hub at the origin
  };
  struct PlacedVehicle {
    std::vector<Part> parts;
    std::vector<PlacedRotor> rotors;
  };

  const GlFunctions& gl_;
  VertexBuffer vertices_;
  std::vector<PlacedVehicle> vehicles_;
};

}  // namespace swiftlet::sim
