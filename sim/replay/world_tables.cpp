// SPDX-License-Identifier: BSD-3-Clause
#include "sim/replay/world_tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

using Json = nlohmann::ordered_json;
using Vector3f = Eigen::Vector3f;
using Triangle = std::array<std::uint32_t, 3>;

constexpr float kMostGrowth = 3.0F;  // of leaves, for those that are left out

Json json_of(const Rgb& color) {
  const auto byte = [&](int c) { return std::lround(255.0F * color[c]); };
  return {byte(0), byte(1), byte(2)};
}

bool has_pieces(const Mesh& mesh) {
  return mesh.surface_class == SurfaceClass::kVegetation || mesh.surface_class == SurfaceClass::kUndergrowth ||
         mesh.surface_class == SurfaceClass::kBranch;
}

/// Its triangles, piece by piece.
std::vector<std::vector<std::uint32_t>> triangles_by_piece(const Mesh& mesh) {
  const std::vector<std::uint32_t> piece_of_vertex = pieces_of(mesh);
  std::vector<std::uint32_t> piece_at(piece_of_vertex.size(), 0);
  std::vector<std::vector<std::uint32_t>> pieces;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    std::uint32_t& number = piece_at[piece_of_vertex[mesh.triangles[i][0]]];  // from 1
    if (number == 0) {
      pieces.emplace_back();
      number = static_cast<std::uint32_t>(pieces.size());
    }
    pieces[number - 1].push_back(i);
  }
  return pieces;
}

/// A share of the pieces, evenly over the mesh: leaves grow to cover as much as all did; branches stay as they are.
Mesh thinned(const Mesh& mesh, double share) {
  constexpr double kFewest = 6.0;  // pieces of a mesh: no tree is left bare
  const auto pieces = triangles_by_piece(mesh);
  share = std::min(1.0, std::max(share, kFewest / static_cast<double>(pieces.size())));
  Mesh out = mesh;
  out.triangles.clear();
  const float growth = mesh.surface_class == SurfaceClass::kBranch
                           ? 1.0F
                           : std::min(kMostGrowth, static_cast<float>(std::sqrt(1.0 / share)));
  double due = 0.0;
  for (const auto& piece : pieces) {
    due += share;
    if (due < 1.0) continue;
    due -= 1.0;
    Vector3f middle_mesh_m = Vector3f::Zero();
    for (const std::uint32_t i : piece) {
      for (const std::uint32_t v : mesh.triangles[i]) middle_mesh_m += mesh.vertices_mesh_m[v];
    }
    middle_mesh_m /= static_cast<float>(3 * piece.size());
    for (const std::uint32_t i : piece) {
      out.triangles.push_back(mesh.triangles[i]);
      for (const std::uint32_t v : mesh.triangles[i])
        out.vertices_mesh_m[v] = middle_mesh_m + growth * (mesh.vertices_mesh_m[v] - middle_mesh_m);
    }
  }
  return out;
}

/// All vertices of a cell of that edge become one; triangles that lose a corner vanish.
Mesh coarsened(const Mesh& mesh, float edge_m) {
  Mesh out = mesh;
  out.triangles.clear();
  std::map<std::array<int, 3>, std::uint32_t> first_in;
  std::vector<std::uint32_t> became(mesh.vertices_mesh_m.size());
  for (std::uint32_t i = 0; i < became.size(); ++i) {
    std::array<int, 3> cell{};
    for (int c = 0; c < 3; ++c) cell[c] = static_cast<int>(std::floor(mesh.vertices_mesh_m[i][c] / edge_m));
    became[i] = first_in.emplace(cell, i).first->second;
  }
  for (const Triangle& t : mesh.triangles) {
    const Triangle kept{became[t[0]], became[t[1]], became[t[2]]};
    if (kept[0] != kept[1] && kept[1] != kept[2] && kept[2] != kept[0]) out.triangles.push_back(kept);
  }
  return out;
}

/// Vertices in the order of their first use, and three numbers for each triangle.
void append_mesh(const Mesh& mesh, Json about, ReplayBlock& block) {
  constexpr double kStep_m = 0.002;
  about["table"] = "vertices";
  ReplayTable vertices(about.dump(), {{"x_m", kStep_m}, {"y_m", kStep_m}, {"z_m", kStep_m}});
  ReplayTable triangles(Json::object({{"table", "triangles"}}).dump(), {{"a", 1.0}, {"b", 1.0}, {"c", 1.0}});
  std::vector<std::uint32_t> number(mesh.vertices_mesh_m.size(), 0);  // from 1
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

struct Shares {
  double of_pieces = 1.0;
  float edge_m = 0.0F;  ///< of the cells that make the rest coarser; 0: it stays as it is
};

Shares shares_of(const Scene& scene, std::size_t most_triangles) {
  std::vector<std::size_t> uses(scene.meshes.size(), 0);
  for (const Instance& instance : scene.instances) ++uses[instance.mesh];
  double pieces = 0.0, rest = 0.0;
  for (std::size_t m = 0; m < uses.size(); ++m) {
    (has_pieces(scene.meshes[m]) ? pieces : rest) +=
        static_cast<double>(uses[m]) * static_cast<double>(scene.meshes[m].triangles.size());
  }
  const double half = 0.5 * static_cast<double>(most_triangles);
  Shares shares;
  const auto count_at = [&](float edge_m) {
    double count = 0.0;
    for (std::size_t m = 0; m < uses.size(); ++m) {
      if (uses[m] == 0 || has_pieces(scene.meshes[m])) continue;
      count += static_cast<double>(uses[m]) * static_cast<double>(coarsened(scene.meshes[m], edge_m).triangles.size());
    }
    return count;
  };
  constexpr float kFirstEdge_m = 0.05F, kLastEdge_m = 100.0F;
  for (double left = rest; left > std::max(half, 2.0 * half - pieces);) {
    shares.edge_m = shares.edge_m == 0.0F ? kFirstEdge_m : 1.5F * shares.edge_m;
    if (shares.edge_m > kLastEdge_m) break;
    rest = left = count_at(shares.edge_m);
  }
  if (pieces > 0.0) shares.of_pieces = std::clamp((2.0 * half - rest) / pieces, 0.02, 1.0);
  return shares;
}

const char* kind_of(const Mesh& mesh) {
  if (mesh.surface_class == SurfaceClass::kGround) return "ground";
  return has_pieces(mesh) && mesh.surface_class != SurfaceClass::kBranch ? "plant" : "plain";
}

}  // namespace

void append_world(const Scene& scene, std::size_t most_triangles, ReplayBlock& block) {
  constexpr double kTurnStep = 1e-4, kPlaceStep_m = 1e-3;
  const Shares shares = shares_of(scene, most_triangles);
  std::vector<std::vector<const Instance*>> instances_of(scene.meshes.size());
  for (const Instance& instance : scene.instances) instances_of[instance.mesh].push_back(&instance);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    if (instances_of[m].empty() || mesh.triangles.empty()) continue;
    const Json about = {{"color", json_of(scene.materials.at(mesh.material).color_rgb)}, {"kind", kind_of(mesh)}};
    if (has_pieces(mesh) && shares.of_pieces < 1.0) {
      append_mesh(thinned(mesh, shares.of_pieces), about, block);
    } else if (!has_pieces(mesh) && shares.edge_m > 0.0F) {
      append_mesh(coarsened(mesh, shares.edge_m), about, block);
    } else {
      append_mesh(mesh, about, block);
    }
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
