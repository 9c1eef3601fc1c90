// SPDX-License-Identifier: BSD-3-Clause
#include "sim/replay/world_tables.hpp"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "swiftlet/sim/render/colors.hpp"
#include "swiftlet/sim/world/thinned_scene.hpp"

namespace swiftlet::sim {
namespace {

using Json = nlohmann::ordered_json;
using Vector3f = Eigen::Vector3f;
using Triangle = std::array<std::uint32_t, 3>;

Json json_of(const Rgb& color) {
  const auto byte = [&](int c) { return std::lround(255.0F * color[c]); };
  return {byte(0), byte(1), byte(2)};
}

/// Vertices in the order of their first use, and three indices for each triangle.
void append_mesh(const Mesh& mesh, Json about, ReplayBlock& block) {
  // [m] Resolution of the vertices.
  constexpr double kStep_m = 0.002;
  about["table"] = "vertices";
  ReplayTable vertices(about.dump(), {{"x_m", kStep_m}, {"y_m", kStep_m}, {"z_m", kStep_m}});
  ReplayTable triangles(Json::object({{"table", "triangles"}}).dump(), {{"a", 1.0}, {"b", 1.0}, {"c", 1.0}});
  std::vector<std::uint32_t> number(mesh.vertices_mesh_m.size(), 0);  // 1 + row of each vertex; 0: not written yet
  const auto number_of = [&](std::uint32_t v) -> double {
    if (number[v] == 0) {
      const Vector3f& p = mesh.vertices_mesh_m[v];
      vertices.add({p.x(), p.y(), p.z()});
      number[v] = static_cast<std::uint32_t>(vertices.rows());
    }
    return number[v] - 1;
  };
  for (const Triangle& t : mesh.triangles) {
    const double a = number_of(t[0]), b = number_of(t[1]), c = number_of(t[2]);
    triangles.add({a, b, c});
  }
  block.add(vertices);
  block.add(triangles);
}

const char* kind_of(const Mesh& mesh) {
  if (mesh.surface_class == SurfaceClass::kGround) return "ground";
  return is_plant(mesh) && mesh.surface_class != SurfaceClass::kBranch ? "plant" : "plain";
}

}  // namespace

void append_world(const Scene& whole, std::size_t most_triangles, ReplayBlock& block) {
  // Resolution of quaternions [-] and positions [m].
  constexpr double kTurnStep = 1e-4, kPlaceStep_m = 1e-3;
  const Scene scene = thinned_scene(whole, most_triangles);
  std::vector<std::vector<const Instance*>> instances_of(scene.meshes.size());
  for (const Instance& instance : scene.instances) instances_of[instance.mesh].push_back(&instance);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    if (instances_of[m].empty() || mesh.triangles.empty()) continue;
    const Json about = {{"color", json_of(scene.materials.at(mesh.material).color_rgb)}, {"kind", kind_of(mesh)}};
    append_mesh(mesh, about, block);
    std::vector<ReplayColumn> columns;
    for (const char* name : {"xx", "yx", "zx", "xy", "yy", "zy", "xz", "yz", "zz"})
      columns.push_back({name, kTurnStep});
    for (const char* name : {"x_m", "y_m", "z_m"}) columns.push_back({name, kPlaceStep_m});
    columns.push_back({"instance", 1.0});
    ReplayTable places(Json::object({{"table", "places"}}).dump(), columns);
    for (const Instance* instance : instances_of[m]) {
      std::array<double, 13> row{};
      for (int i = 0; i < 12; ++i) row[i] = instance->T_world_mesh.matrix()(i % 3, i / 3);
      row[12] = instance->instance;
      places.add(row);
    }
    block.add(places);
  }
}

void append_vehicle(const VehicleShape& shape, VehicleId vehicle, ReplayBlock& block) {
  for (const Mesh& mesh : shape.meshes) {
    append_mesh(mesh, {{"color", json_of(part_color(shape, mesh, vehicle))}, {"vehicle", vehicle}}, block);
  }
  ReplayTable rotors(Json::object({{"table", "rotors"}, {"vehicle", vehicle}}).dump(), {{"x_m", 1e-3},
                                                                                        {"y_m", 1e-3},
                                                                                        {"z_m", 1e-3},
                                                                                        {"radius_m", 1e-3},
                                                                                        {"chord_m", 1e-3},
                                                                                        {"blades", 1.0},
                                                                                        {"direction", 1.0}});
  for (const auto& rotor : shape.rotors) {
    const Vector3f& hub = rotor.hub_body_m;
    rotors.add(
        {hub.x(), hub.y(), hub.z(), rotor.radius_m, rotor.chord_m, static_cast<double>(rotor.blades), rotor.direction});
  }
  block.add(rotors);
}

}  // namespace swiftlet::sim
