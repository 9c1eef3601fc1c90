// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/thinned_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

namespace swiftlet::sim {
namespace {

using Vector3f = Eigen::Vector3f;
using Triangle = std::array<std::uint32_t, 3>;

constexpr float kMostGrowth = 3.0F;  // largest enlargement of leaves that compensates omitted ones

/// Triangles of a mesh, grouped by connected piece.
std::vector<std::vector<std::uint32_t>> triangles_by_piece(const Mesh& mesh) {
  const std::vector<std::uint32_t> piece_of_vertex = pieces_of(mesh);
  std::vector<std::uint32_t> piece_at(piece_of_vertex.size(), 0);
  std::vector<std::vector<std::uint32_t>> pieces;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    std::uint32_t& number = piece_at[piece_of_vertex[mesh.triangles[i][0]]];  // counted from 1
    if (number == 0) {
      pieces.emplace_back();
      number = static_cast<std::uint32_t>(pieces.size());
    }
    pieces[number - 1].push_back(i);
  }
  return pieces;
}

/// Keeps a share of the pieces, evenly over the mesh: leaves grow to cover the same area; branches are unchanged.
Mesh thinned(const Mesh& mesh, double share) {
  constexpr double kFewest = 6.0;  // least number of pieces of a mesh, so that no tree is bare
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

/// Merges all vertices within a cell of that edge; degenerate triangles are removed.
Mesh coarsened(const Mesh& mesh, float edge_m) {
  Mesh out = mesh;
  out.triangles.clear();
  std::map<std::array<int, 3>, std::uint32_t> first_in;
  std::vector<std::uint32_t> merged_into(mesh.vertices_mesh_m.size());
  for (std::uint32_t i = 0; i < merged_into.size(); ++i) {
    std::array<int, 3> cell{};
    for (int c = 0; c < 3; ++c) cell[c] = static_cast<int>(std::floor(mesh.vertices_mesh_m[i][c] / edge_m));
    merged_into[i] = first_in.emplace(cell, i).first->second;
  }
  for (const Triangle& t : mesh.triangles) {
    const Triangle kept{merged_into[t[0]], merged_into[t[1]], merged_into[t[2]]};
    if (kept[0] != kept[1] && kept[1] != kept[2] && kept[2] != kept[0]) out.triangles.push_back(kept);
  }
  return out;
}

struct Shares {
  double of_pieces = 1.0;
  float edge_m = 0.0F;  ///< cell edge for coarsening all other meshes; 0: unchanged
};

Shares shares_of(const Scene& scene, std::size_t most_triangles) {
  std::vector<std::size_t> uses(scene.meshes.size(), 0);
  for (const Instance& instance : scene.instances) ++uses[instance.mesh];
  double pieces = 0.0, rest = 0.0;
  for (std::size_t m = 0; m < uses.size(); ++m) {
    (is_plant(scene.meshes[m]) ? pieces : rest) +=
        static_cast<double>(uses[m]) * static_cast<double>(scene.meshes[m].triangles.size());
  }
  const double half = 0.5 * static_cast<double>(most_triangles);
  Shares shares;
  const auto count_at = [&](float edge_m) {
    double count = 0.0;
    for (std::size_t m = 0; m < uses.size(); ++m) {
      if (uses[m] == 0 || is_plant(scene.meshes[m])) continue;
      count += static_cast<double>(uses[m]) * static_cast<double>(coarsened(scene.meshes[m], edge_m).triangles.size());
    }
    return count;
  };
  // [m] First and last edge of the cells that coarsen a mesh.
  constexpr float kFirstEdge_m = 0.05F, kLastEdge_m = 100.0F;
  for (double left = rest; left > std::max(half, 2.0 * half - pieces);) {
    shares.edge_m = shares.edge_m == 0.0F ? kFirstEdge_m : 1.5F * shares.edge_m;
    if (shares.edge_m > kLastEdge_m) break;
    rest = left = count_at(shares.edge_m);
  }
  if (pieces > 0.0) shares.of_pieces = std::clamp((2.0 * half - rest) / pieces, 0.02, 1.0);
  return shares;
}

}  // namespace

bool is_plant(const Mesh& mesh) {
  return mesh.surface_class == SurfaceClass::kVegetation || mesh.surface_class == SurfaceClass::kUndergrowth ||
         mesh.surface_class == SurfaceClass::kBranch;
}

Scene thinned_scene(const Scene& scene, std::size_t most_triangles) {
  const Shares shares = shares_of(scene, most_triangles);
  Scene out = scene;
  for (Mesh& mesh : out.meshes) {
    if (mesh.triangles.empty()) continue;
    if (is_plant(mesh) && shares.of_pieces < 1.0) {
      mesh = thinned(mesh, shares.of_pieces);
    } else if (!is_plant(mesh) && shares.edge_m > 0.0F) {
      mesh = coarsened(mesh, shares.edge_m);
    }
  }
  return out;
}

}  // namespace swiftlet::sim
