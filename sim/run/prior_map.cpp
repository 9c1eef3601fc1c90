// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/prior_map.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/octomap/octomap_file.hpp"
#include "swiftlet/sim/run/memory.hpp"
#include "swiftlet/sim/slam_map/slam_map_file.hpp"
#include "swiftlet/sim/world/mesh_import.hpp"
#include "swiftlet/sim/world/point_cloud_file.hpp"

namespace swiftlet::sim {
namespace {

// [-] Samples along an edge of a voxel. Smaller values may leave voxels without a sample.
constexpr double kSamplesPerVoxel = 3.0;

enum class What { kOccupied, kFree };

void append_cells(const std::filesystem::path& file, What what, const std::string& key,
                  std::vector<Eigen::Vector3f>& points_m) {
  const OctomapCells cells = read_octomap(file, [&](double bytes) { require_memory(key, bytes); });
  const auto& chosen_m = what == What::kOccupied ? cells.occupied_m : cells.free_m;
  points_m.insert(points_m.end(), chosen_m.begin(), chosen_m.end());
}

void append_cloud(const std::filesystem::path& file, What what, const std::string& key,
                  std::vector<Eigen::Vector3f>& points_m) {
  if (is_octomap_file(file)) return append_cells(file, what, key, points_m);
  if (is_slam_map_file(file)) {
    if (what == What::kFree)
      throw InputError(key + ": expected a map with free voxels, found a SLAM map, which stores none");
    const std::vector<Eigen::Vector3f> of_map_m = points_world_m(read_slam_map(file));
    points_m.insert(points_m.end(), of_map_m.begin(), of_map_m.end());
    return;
  }
  for (const Eigen::Vector3d& p : read_point_cloud(file)) points_m.push_back(p.cast<float>());
}

// The clouds of a recorded run, located by its recorder's index.
void append_recorded(const std::filesystem::path& index, const std::string& key,
                     std::vector<Eigen::Vector3f>& points_m) {
  std::ifstream in(index);
  if (!in) throw InputError(key + ": cannot read " + index.string());
  std::string line;
  std::getline(in, line);
  if (line.rfind("file,", 0) != 0) {
    throw InputError(
        key + ": expected a recorder's index, whose first column is 'file', found another file: " + index.string());
  }
  while (std::getline(in, line)) {
    append_cloud(index.parent_path() / line.substr(0, line.find(',')), What::kOccupied, key, points_m);
  }
}

int samples_of(const Eigen::Vector3f& u, const Eigen::Vector3f& v, double spacing_m) {
  const double longest_m = std::max({u.norm(), v.norm(), (u - v).norm()});
  return std::max(1, static_cast<int>(std::min(std::ceil(longest_m / spacing_m), 1e6)));
}

/// Calls visit(corner, edge, edge) for every triangle.
template <class Visit>
void for_each_triangle(const Scene& scene, const Visit& visit) {
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const auto& triangle : mesh.triangles) {
      const Eigen::Vector3f a = instance.T_world_mesh * mesh.vertices_mesh_m[triangle[0]];
      const Eigen::Vector3f u = instance.T_world_mesh * mesh.vertices_mesh_m[triangle[1]] - a;
      const Eigen::Vector3f v = instance.T_world_mesh * mesh.vertices_mesh_m[triangle[2]] - a;
      visit(a, u, v);
    }
  }
}

}  // namespace

void append_surface_points(const Scene& scene, double spacing_m, const std::string& key,
                           std::vector<Eigen::Vector3f>& points_world_m) {
  double count = 0.0;
  for_each_triangle(scene, [&](const auto& /*a*/, const auto& u, const auto& v) {
    const double n = samples_of(u, v, spacing_m);
    count += 0.5 * (n + 1.0) * (n + 2.0);
  });
  require_memory(key, count * sizeof(Eigen::Vector3f));
  points_world_m.reserve(points_world_m.size() + static_cast<std::size_t>(count));
  for_each_triangle(scene, [&](const auto& a, const auto& u, const auto& v) {
    const int n = samples_of(u, v, spacing_m);
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) {
        points_world_m.push_back(a + u * (static_cast<float>(i) / static_cast<float>(n)) +
                                 v * (static_cast<float>(j) / static_cast<float>(n)));
      }
    }
  });
}

std::shared_ptr<const PriorMap> make_prior_map(const PriorConfig& config, double voxel_m, const Scene& world,
                                               const std::string& key) {
  auto prior = std::make_shared<PriorMap>();
  const double spacing_m = voxel_m / kSamplesPerVoxel;
  // A file without any valid point is an error.
  const auto append_file = [&](const std::string& file, const char* name, std::vector<Eigen::Vector3f>& points_m,
                               const auto& append) {
    if (file.empty()) return;
    const std::size_t before = points_m.size();
    append(key + name);
    if (points_m.size() == before)
      throw InputError(key + name + ": expected points with finite coordinates in " + file + ", found none");
  };
  std::vector<Eigen::Vector3f>& occupied_m = prior->occupied_world_m;
  append_file(config.occupied, ".occupied", occupied_m,
              [&](const std::string& of_key) { append_cloud(config.occupied, What::kOccupied, of_key, occupied_m); });
  append_file(config.free, ".free", prior->free_world_m,
              [&](const std::string& of_key) { append_cloud(config.free, What::kFree, of_key, prior->free_world_m); });
  append_file(config.recorded, ".recorded", occupied_m,
              [&](const std::string& of_key) { append_recorded(config.recorded, of_key, occupied_m); });
  append_file(config.mesh, ".mesh", occupied_m, [&](const std::string& of_key) {
    MeshImportConfig mesh;
    mesh.file = config.mesh;
    const Scene scene = make_mesh_import(mesh, 0);
    append_surface_points(scene, spacing_m, of_key, occupied_m);
    for (Counter counter : scene.counters) {
      counter.setting = "prior.mesh";
      prior->counters.push_back(std::move(counter));
    }
  });
  if (config.world) append_surface_points(world, spacing_m, key + ".world", prior->occupied_world_m);
  if (prior->occupied_world_m.empty() && prior->free_world_m.empty()) return nullptr;
  return prior;
}

}  // namespace swiftlet::sim
