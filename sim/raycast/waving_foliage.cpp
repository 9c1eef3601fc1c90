// SPDX-License-Identifier: BSD-3-Clause
#include "sim/raycast/waving_foliage.hpp"

#include <algorithm>

#include "sim/raycast/exact_hits_internal.hpp"

namespace swiftlet::sim {
namespace {

bool waves(const Mesh& mesh) { return mesh.surface_class == SurfaceClass::kVegetation; }

double top_m(const Mesh& mesh, const Eigen::Affine3f& T_world_mesh) {
  double top = -std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) {
    top = std::max(top, static_cast<double>((T_world_mesh * vertex).z()));
  }
  return top;
}

// For each triangle of a mesh, the height of its connected piece, indexed like the mesh's triangles.
std::vector<double> heights_m(const Mesh& mesh, const std::vector<std::uint32_t>& piece_of_vertex,
                              const Eigen::Affine3f& T_world_mesh) {
  std::vector<double> sum_m(piece_of_vertex.size(), 0.0);
  std::vector<int> count(piece_of_vertex.size(), 0);
  for (std::size_t v = 0; v < piece_of_vertex.size(); ++v) {
    sum_m[piece_of_vertex[v]] += static_cast<double>((T_world_mesh * mesh.vertices_mesh_m[v]).z());
    ++count[piece_of_vertex[v]];
  }
  std::vector<double> heights;
  heights.reserve(mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    const std::uint32_t piece = piece_of_vertex[triangle[0]];
    heights.push_back(sum_m[piece] / count[piece]);
  }
  return heights;
}

void copy_triangle(const TriangleScene& from, std::size_t triangle, TriangleScene& to) {
  to.corners_m.push_back(from.corners_m[triangle]);
  to.facets.push_back(from.facets[triangle]);
}

}  // namespace

std::unique_ptr<Foliage> make_foliage(const Scene& scene, const TriangleScene& world,
                                      const std::vector<std::uint32_t>& first_triangle) {
  if (!scene.foliage.moves()) return nullptr;
  auto foliage = std::make_unique<Foliage>(FoliageMotion(scene.foliage, scene.foliage_seed));
  foliage->rest.surfaces = foliage->firm.surfaces = world.surfaces;
  std::vector<std::vector<std::uint32_t>> pieces(scene.meshes.size());
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (!waves(mesh)) {
      for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
        copy_triangle(world, first_triangle[i] + k, foliage->firm);
      continue;
    }
    std::vector<std::uint32_t>& piece_of_vertex = pieces[instance.mesh];
    if (piece_of_vertex.empty()) piece_of_vertex = pieces_of(mesh);
    const double foot = static_cast<double>(instance.T_world_mesh.translation().z());
    const double height = std::max(top_m(mesh, instance.T_world_mesh) - foot, 1e-3);
    const std::vector<double> heights = heights_m(mesh, piece_of_vertex, instance.T_world_mesh);
    const std::uint32_t tree = foliage->num_trees++;
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
      copy_triangle(world, first_triangle[i] + k, foliage->rest);
      foliage->tree.push_back(tree);
      foliage->pattern.push_back(foliage->motion.pattern_of(tree, piece_of_vertex[mesh.triangles[k][0]]));
      foliage->share_of_sway.push_back(static_cast<float>(FoliageMotion::share_of_sway((heights[k] - foot) / height)));
    }
  }
  if (foliage->rest.size() == 0) return nullptr;
  return foliage;
}

WavingFoliage::WavingFoliage(std::shared_ptr<const StaticScene> world) : world_(std::move(world)) {
  leaves_.corners_m = foliage().rest.corners_m;
  leaves_.facets = foliage().rest.facets;
  leaves_.surfaces = foliage().rest.surfaces;
  prepare_for_exact_hits(leaves_);
  enlarged_at_rest_m_ = leaves_.enlarged_m;
  sway_m_.resize(foliage().num_trees);
  leaves_.commit_to_move(world_->impl().device.get());
}

void WavingFoliage::move_to(TimeNs t) {
  const Foliage& leaves = foliage();
  const double t_s = to_seconds(t);
  for (std::uint32_t tree = 0; tree < leaves.num_trees; ++tree)
    sway_m_[tree] = leaves.motion.sway_m(tree, t_s).cast<float>();
  for (std::uint32_t pattern = 0; pattern < FoliageMotion::kNumPatterns; ++pattern)
    flutter_m_[pattern] = leaves.motion.flutter_m(pattern, t_s).cast<float>();
  const auto count = static_cast<std::int64_t>(leaves_.size());
#pragma omp parallel for schedule(static) if (count > 10'000)
  for (std::int64_t i = 0; i < count; ++i) {
    const Eigen::Vector3f displacement_m =
        leaves.share_of_sway[i] * sway_m_[leaves.tree[i]] + flutter_m_[leaves.pattern[i]];
    for (int k = 0; k < 3; ++k) {
      leaves_.corners_m[i][k] = leaves.rest.corners_m[i][k] + displacement_m;
      leaves_.enlarged_m[i][k] = enlarged_at_rest_m_[i][k] + displacement_m;
    }
    leaves_.facets[i].corner_m = leaves_.corners_m[i][0];
  }
  leaves_.refit();
}

}  // namespace swiftlet::sim
