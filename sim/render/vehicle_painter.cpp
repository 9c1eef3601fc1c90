// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/vehicle_painter.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

// [rad/s] Rotor speed below which only the blades are drawn. Larger values show blades that seem to stand still.
constexpr double kDiscSpeed_radps = 30.0;
// [-] Segments of a rotor disc.
constexpr int kDiscSegments = 40;

/// Blades as thin tapered slabs: widest at a third of the radius, narrow at hub and tip.
Mesh blades_of(const VehicleShape::RotorShape& rotor) {
  Mesh mesh;
  const float half_thickness = 0.06F * rotor.chord_m;
  constexpr float kStations[][2] = {{0.04F, 0.45F}, {0.3F, 1.0F}, {0.7F, 0.8F}, {1.0F, 0.35F}};  // radius, chord
  for (int blade = 0; blade < rotor.blades; ++blade) {
    const Eigen::AngleAxisf turn(static_cast<float>(2.0 * M_PI * blade / rotor.blades), Eigen::Vector3f::UnitZ());
    const auto base = static_cast<std::uint32_t>(mesh.vertices_mesh_m.size());
    for (const auto& [radius, chord] : kStations) {
      for (const float side : {-0.5F, 0.5F}) {
        // The leading edge is raised by the blade's pitch, according to the sense of rotation.
        const float tilt = 0.12F * side * chord * rotor.chord_m * rotor.direction;
        for (const float z : {-half_thickness, half_thickness}) {
          mesh.vertices_mesh_m.push_back(
              turn * Eigen::Vector3f(radius * rotor.radius_m, side * chord * rotor.chord_m, z + tilt));
        }
      }
    }
    const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
      mesh.triangles.push_back({base + a, base + b, base + c});
      mesh.triangles.push_back({base + a, base + c, base + d});
    };
    for (std::uint32_t s = 0; s < 3; ++s) {  // vertices of a station: 4 s + 2 * side + top
      const std::uint32_t i = 4 * s;
      quad(i + 1, i + 5, i + 7, i + 3);
      quad(i + 0, i + 2, i + 6, i + 4);
      quad(i + 0, i + 4, i + 5, i + 1);
      quad(i + 2, i + 3, i + 7, i + 6);
    }
    quad(12, 14, 15, 13);
  }
  return mesh;
}

Eigen::Vector4f color_of(const VehicleShape& shape, const Mesh& mesh, VehicleId vehicle) {
  return with_alpha(to_linear(part_color(shape, mesh, vehicle)), static_cast<float>(SurfaceKind::kShiny));
}

Eigen::Affine3f pose_of(const VehicleState& state, double scale) {
  Eigen::Affine3d T = state.T_world_body() * Eigen::Scaling(scale);
  return T.cast<float>();
}

}  // namespace

VehiclePainter::VehiclePainter(const GlFunctions& gl, std::span<const std::shared_ptr<const VehicleShape>> shapes)
    : gl_(gl) {
  std::vector<RenderVertex> vertices;
  std::vector<std::uint32_t> indices;
  const auto add = [&](const Mesh& mesh, const Eigen::Vector4f& color) {
    const RenderMesh ready = prepare_mesh(mesh);
    Part part{static_cast<GLsizei>(indices.size()), static_cast<GLsizei>(ready.indices.size()), color};
    for (const std::uint32_t index : ready.indices)
      indices.push_back(index + static_cast<std::uint32_t>(vertices.size()));
    vertices.insert(vertices.end(), ready.vertices.begin(), ready.vertices.end());
    return part;
  };
  for (std::size_t v = 0; v < shapes.size(); ++v) {
    PlacedVehicle vehicle;
    for (const Mesh& mesh : shapes[v]->meshes) {
      vehicle.parts.push_back(add(mesh, color_of(*shapes[v], mesh, static_cast<VehicleId>(v))));
    }
    for (const auto& rotor : shapes[v]->rotors) {
      const Eigen::Vector4f color =
          with_alpha(to_linear(Rgb(0.10F, 0.10F, 0.11F)), static_cast<float>(SurfaceKind::kShiny));
      vehicle.rotors.push_back({rotor, add(blades_of(rotor), color)});
    }
    vehicles_.push_back(std::move(vehicle));
  }

  vertices_ = make_vertex_buffer(gl_);
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(RenderVertex)), vertices.data(),
                 GL_STATIC_DRAW);
  mesh_attributes(gl_);
  make_buffer(gl_, GL_ELEMENT_ARRAY_BUFFER, indices.data(), indices.size() * sizeof(std::uint32_t));
}

void VehiclePainter::draw(std::span<const VehicleState> states, double scale, VehicleId hidden) const {
  for (std::size_t v = 0; v < states.size(); ++v) {
    if (static_cast<VehicleId>(v) != hidden) draw_one(v, states[v], scale);
  }
}

void VehiclePainter::draw_one(std::size_t vehicle, const VehicleState& state, double scale) const {
  if (vehicle >= vehicles_.size()) return;
  gl_.BindVertexArray(vertices_.array);
  const auto draw_part = [&](const Part& part, const Eigen::Affine3f& T_world_part) {
    for (GLuint row = 0; row < 3; ++row) {
      const Eigen::Vector4f r = T_world_part.matrix().row(row).transpose();
      gl_.VertexAttrib4f(3 + row, r.x(), r.y(), r.z(), r.w());
    }
    gl_.VertexAttrib4f(6, part.color.x(), part.color.y(), part.color.z(), part.color.w());
    gl_.DrawElements(GL_TRIANGLES, part.num_indices, GL_UNSIGNED_INT,
                     reinterpret_cast<const void*>(sizeof(std::uint32_t) * static_cast<std::size_t>(part.first_index)));
  };
  const Eigen::Affine3f T_world_body = pose_of(state, scale);
  for (const Part& part : vehicles_[vehicle].parts) draw_part(part, T_world_body);
  for (std::size_t r = 0; r < vehicles_[vehicle].rotors.size(); ++r) {
    const PlacedRotor& rotor = vehicles_[vehicle].rotors[r];
    const double angle = r < kMaxRotors ? std::fmod(state.rotor_angle_rad[r], 2.0 * M_PI) : 0.0;
    draw_part(rotor.blades, T_world_body * Eigen::Translation3f(rotor.shape.hub_body_m) *
                                Eigen::AngleAxisf(static_cast<float>(angle), Eigen::Vector3f::UnitZ()));
  }
}

void VehiclePainter::append_discs(const View& view, std::span<const VehicleState> states, double scale,
                                  VehicleId hidden, std::vector<ClipVertex>& out) const {
  struct Disc {
    double distance_m;
    std::size_t vehicle;
    std::size_t rotor;
  };
  std::vector<Disc> discs;
  for (std::size_t v = 0; v < std::min(vehicles_.size(), states.size()); ++v) {
    if (static_cast<VehicleId>(v) == hidden) continue;
    for (std::size_t r = 0; r < std::min<std::size_t>(vehicles_[v].rotors.size(), kMaxRotors); ++r) {
      if (states[v].rotor_speed_radps[r] < kDiscSpeed_radps) continue;
      const Eigen::Vector3f hub = pose_of(states[v], scale) * vehicles_[v].rotors[r].shape.hub_body_m;
      discs.push_back({(hub.cast<double>() - view.eye_world_m).norm(), v, r});
    }
  }
  std::stable_sort(discs.begin(), discs.end(),
                   [](const Disc& a, const Disc& b) { return a.distance_m > b.distance_m; });

  const Eigen::Matrix4f clip_world = view.clip_world().cast<float>();
  for (const Disc& disc : discs) {
    const auto& rotor = vehicles_[disc.vehicle].rotors[disc.rotor].shape;
    const Eigen::Matrix4f clip_body = clip_world * pose_of(states[disc.vehicle], scale).matrix();
    const Rgb color = 0.35F * vehicle_color(static_cast<VehicleId>(disc.vehicle)) + Rgb::Constant(0.42F);
    const auto corner = [&](double angle, float radius_share, float alpha) {
      const Eigen::Vector3f p = rotor.hub_body_m + radius_share * rotor.radius_m *
                                                       Eigen::Vector3f(static_cast<float>(std::cos(angle)),
                                                                       static_cast<float>(std::sin(angle)), 0.0F);
      return ClipVertex{clip_body * p.homogeneous(), with_alpha(color, alpha)};
    };
    for (int i = 0; i < kDiscSegments; ++i) {
      const double a = 2.0 * M_PI * i / kDiscSegments;
      const double b = 2.0 * M_PI * (i + 1) / kDiscSegments;
      // Faint inside, with a brighter rim at the blade tips.
      constexpr float kRings[][2] = {{0.0F, 0.22F}, {0.8F, 0.22F}, {1.0F, 0.42F}};
      for (int ring = 0; ring < 2; ++ring) {
        const auto& [r0, alpha0] = kRings[ring];
        const auto& [r1, alpha1] = kRings[ring + 1];
        const ClipVertex inner_a = corner(a, r0, alpha0), inner_b = corner(b, r0, alpha0);
        const ClipVertex outer_a = corner(a, r1, alpha1), outer_b = corner(b, r1, alpha1);
        out.insert(out.end(), {inner_a, outer_a, outer_b});
        if (r0 > 0.0F) out.insert(out.end(), {inner_a, outer_b, inner_b});
      }
    }
  }
}

}  // namespace swiftlet::sim
