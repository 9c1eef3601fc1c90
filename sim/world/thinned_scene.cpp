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

/// [-] Largest factor of the size of kept leaves, which compensates for the area of removed ones. Larger values keep
/// crowns dense, but with conspicuously large leaves.
constexpr float kMaxGrowth = 3.0F;

/// Triangle indices of a mesh, grouped by connected component.
std::vector<std::vector<std::uint32_t>> triangles_by_piece(const Mesh& mesh) {
  const std::vector<std::uint32_t> piece_of_vertex = pieces_of(mesh);
  std::vector<std::uint32_t> piece_at(piece_of_vertex.size(), 0);
  std::vector<std::vector<std::uint32_t>> pieces;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    std::uint32_t& number = piece_at[piece_of_vertex[mesh.triangles[i][0]]];  // 1 + index in pieces; 0: none
    if (number == 0) {
      pieces.emplace_back();
      number = static_cast<std::uint32_t>(pieces.size());
    }
    pieces[number - 1].push_back(i);
  }
  return pieces;
}

/// Keeps a share of the connected pieces (leaves or branches), evenly over the mesh. Kept leaves grow to cover the same
/// area; kept branches are unchanged.
Mesh thinned(const Mesh& mesh, double share) {
  // [-] Least number of kept pieces of a mesh, so that no tree is bare.
  constexpr double kFewest = 6.0;
  const auto pieces = triangles_by_piece(mesh);
  share = std::min(1.0, std::max(share, kFewest / static_cast<double>(pieces.size())));
  Mesh out = mesh;
  out.triangles.clear();
  const float growth = mesh.surface_class == SurfaceClass::kBranch
                           ? 1.0F
                           : std::min(kMaxGrowth, static_cast<float>(std::sqrt(1.0 / share)));
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

/// Vertex clustering: merges all vertices within a cubic cell with this edge and removes degenerate triangles.
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

/// Amounts by which plants are thinned and other meshes are coarsened.
struct Reduction {
  double piece_share = 1.0;  ///< [-] kept share of the pieces of plants
  float edge_m = 0.0F;       ///< [m] cell edge for coarsening all other meshes; 0: unchanged
};

Reduction reduction_for(const Scene& scene, std::size_t most_triangles) {
  std::vector<std::size_t> uses(scene.meshes.size(), 0);
  for (const Instance& instance : scene.instances) ++uses[instance.mesh];
  double plants = 0.0, rest = 0.0;  // numbers of triangles
  for (std::size_t m = 0; m < uses.size(); ++m) {
    (is_plant(scene.meshes[m]) ? plants : rest) +=
        static_cast<double>(uses[m]) * static_cast<double>(scene.meshes[m].triangles.size());
  }
  const double half = 0.5 * static_cast<double>(most_triangles);
  Reduction reduction;
  const auto count_at = [&](float edge_m) {
    double count = 0.0;
    for (std::size_t m = 0; m < uses.size(); ++m) {
      if (uses[m] == 0 || is_plant(scene.meshes[m])) continue;
      count += static_cast<double>(uses[m]) * static_cast<double>(coarsened(scene.meshes[m], edge_m).triangles.size());
    }
    return count;
  };
  // [m] Finest and coarsest cells that are tried.
  constexpr float kFirstEdge_m = 0.05F, kLastEdge_m = 100.0F;
  // [-] Ratio of consecutive edges. Smaller values meet the number of triangles more closely, in more attempts.
  constexpr float kEdgeRatio = 1.5F;
  // [-] Least share of the pieces of plants, however many triangles the scene has.
  constexpr double kMinShare = 0.02;
  // All other meshes may have half of the triangles, and the part of the other half that plants do not need.
  while (rest > std::max(half, 2.0 * half - plants)) {
    reduction.edge_m = reduction.edge_m == 0.0F ? kFirstEdge_m : kEdgeRatio * reduction.edge_m;
    if (reduction.edge_m > kLastEdge_m) break;
    rest = count_at(reduction.edge_m);
  }
  if (plants > 0.0) reduction.piece_share = std::clamp((2.0 * half - rest) / plants, kMinShare, 1.0);
  return reduction;
}

}  // namespace

bool is_plant(const Mesh& mesh) {
  return mesh.surface_class == SurfaceClass::kVegetation || mesh.surface_class == SurfaceClass::kUndergrowth ||
         mesh.surface_class == SurfaceClass::kBranch;
}

Scene thinned_scene(const Scene& scene, std::size_t most_triangles) {
  const Reduction reduction = reduction_for(scene, most_triangles);
  Scene out = scene;
  for (Mesh& mesh : out.meshes) {
    if (mesh.triangles.empty()) continue;
    if (is_plant(mesh) && reduction.piece_share < 1.0) {
      mesh = thinned(mesh, reduction.piece_share);
    } else if (!is_plant(mesh) && reduction.edge_m > 0.0F) {
      mesh = coarsened(mesh, reduction.edge_m);
    }
  }
  return out;
}

}  // namespace swiftlet::sim
