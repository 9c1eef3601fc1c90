// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/cloud.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "sim/world/input_file.hpp"
#include "sim/world/scene_builder.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"
#include "swiftlet/sim/world/point_cloud_file.hpp"

namespace swiftlet::sim {
namespace {

// [voxels] Bound of the indices along each axis, neighbors included. Larger values exceed the kBits of a key.
constexpr std::int64_t kReach = 1 << 20;
// [bits] Bits of a key for each axis: three times as many fit into 64.
constexpr int kBits = 21;

using Voxel = std::array<std::int32_t, 3>;

// Encodes voxels as numbers that sort by x, then y, then z.
std::uint64_t key_of(const Voxel& voxel) {
  std::uint64_t key = 0;
  for (const std::int32_t index : voxel) key = (key << kBits) | static_cast<std::uint64_t>(index + kReach);
  return key;
}

Voxel voxel_of(std::uint64_t key) {
  Voxel voxel;
  for (int axis = 2; axis >= 0; --axis, key >>= kBits) {
    voxel[axis] = static_cast<std::int32_t>(static_cast<std::int64_t>(key & ((1ULL << kBits) - 1)) - kReach);
  }
  return voxel;
}

std::vector<std::uint64_t> occupied_voxels(std::span<const Eigen::Vector3d> points_m, double leaf_m, int min_points) {
  std::vector<std::uint64_t> keys;
  keys.reserve(points_m.size());
  for (const Eigen::Vector3d& point : points_m) {
    Voxel voxel;
    for (int axis = 0; axis < 3; ++axis) {
      const double index = std::floor(point[axis] / leaf_m);
      if (std::abs(index) >= kReach - 2) {
        throw InputError("expected points within " + std::to_string(kReach * leaf_m) +
                         " m of the world's origin at this leaf_m, found a coordinate of " +
                         std::to_string(point[axis]) + " m; position_m moves a cloud");
      }
      voxel[axis] = static_cast<std::int32_t>(index);
    }
    keys.push_back(key_of(voxel));
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint64_t> occupied;
  for (std::size_t i = 0; i < keys.size();) {
    std::size_t end = i;
    while (end < keys.size() && keys[end] == keys[i]) ++end;
    if (end - i >= static_cast<std::size_t>(min_points)) occupied.push_back(keys[i]);
    i = end;
  }
  return occupied;
}

// Adjacent faces of one direction in a plane: columns [v_begin, v_end) of row u.
struct Strip {
  std::int32_t slice, v_begin, v_end, u;
  auto order_in_plane() const { return std::tie(slice, u, v_begin); }
  auto order_by_extent() const { return std::tie(slice, v_begin, v_end, u); }
};

std::vector<Strip> exposed_strips(const std::vector<std::uint64_t>& occupied, int axis, int side) {
  const int u_axis = (axis + 1) % 3;
  const int v_axis = (axis + 2) % 3;
  std::vector<Strip> cells;
  for (const std::uint64_t key : occupied) {
    const Voxel voxel = voxel_of(key);
    Voxel neighbor = voxel;
    neighbor[axis] += side;
    if (std::binary_search(occupied.begin(), occupied.end(), key_of(neighbor))) continue;
    cells.push_back({voxel[axis], voxel[v_axis], voxel[v_axis] + 1, voxel[u_axis]});
  }
  std::sort(cells.begin(), cells.end(),
            [](const Strip& a, const Strip& b) { return a.order_in_plane() < b.order_in_plane(); });
  std::vector<Strip> strips;
  for (const Strip& cell : cells) {
    if (!strips.empty() && strips.back().slice == cell.slice && strips.back().u == cell.u &&
        strips.back().v_end == cell.v_begin) {
      strips.back().v_end = cell.v_end;
    } else {
      strips.push_back(cell);
    }
  }
  return strips;
}

void add_faces(Mesh& mesh, std::vector<Strip> strips, int axis, int side, double leaf_m) {
  const int u_axis = (axis + 1) % 3;
  const int v_axis = (axis + 2) % 3;
  std::sort(strips.begin(), strips.end(),
            [](const Strip& a, const Strip& b) { return a.order_by_extent() < b.order_by_extent(); });
  for (std::size_t i = 0; i < strips.size();) {
    // Merges equal strips of consecutive rows into one rectangle.
    std::size_t end = i + 1;
    while (end < strips.size() && strips[end].slice == strips[i].slice && strips[end].v_begin == strips[i].v_begin &&
           strips[end].v_end == strips[i].v_end && strips[end].u == strips[end - 1].u + 1) {
      ++end;
    }
    const auto corner = [&](std::int32_t u, std::int32_t v) {
      Eigen::Vector3f p;
      p[axis] = static_cast<float>((strips[i].slice + (side > 0 ? 1 : 0)) * leaf_m);
      p[u_axis] = static_cast<float>(u * leaf_m);
      p[v_axis] = static_cast<float>(v * leaf_m);
      return p;
    };
    const std::int32_t u0 = strips[i].u;
    const std::int32_t u1 = strips[end - 1].u + 1;
    const std::int32_t v0 = strips[i].v_begin;
    const std::int32_t v1 = strips[i].v_end;
    if (side > 0)
      add_quad(mesh, corner(u0, v0), corner(u1, v0), corner(u1, v1), corner(u0, v1));
    else
      add_quad(mesh, corner(u0, v0), corner(u0, v1), corner(u1, v1), corner(u1, v0));
    i = end;
  }
}

}  // namespace

void CloudConfig::visit(ConfigVisitor& v) {
  v.file("file", file, "[-] point cloud: .pcd (ascii, binary, binary_compressed) or .ply (ascii, binary)");
  v.field("leaf_m", leaf_m, "[m] edge of a voxel", Range::between(0.005, 100.0));
  v.field("min_points", min_points, "[-] minimum number of points in a solid voxel", Range::between(1, 1000000));
  v.field("scale", scale, "[-] meters per unit of the file", Range::positive());
  v.field("yaw_deg", yaw_deg, "[deg] turn about the vertical, after scaling");
  v.field("position_m", position_m, "[m] position of the file's origin in the world");
  v.choice("class", surface_class, static_class_names(), "[-] truth class of all surfaces");
  v.field("reflectivity", reflectivity, "[-] Lambertian reflectivity of all surfaces", Range::probability());
}

Mesh voxelize(std::span<const Eigen::Vector3d> points_m, double leaf_m, int min_points) {
  const std::vector<std::uint64_t> occupied = occupied_voxels(points_m, leaf_m, min_points);
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) add_faces(mesh, exposed_strips(occupied, axis, side), axis, side, leaf_m);
  }
  return mesh;
}

Scene make_cloud(const CloudConfig& config, std::uint64_t) {
  if (config.file.empty()) throw InputError("world cloud: file: expected the name of a point cloud, found none");
  std::vector<Eigen::Vector3d> points_m = read_point_cloud(config.file);
  if (points_m.empty()) reject_file(config.file, "expected points with finite coordinates, found none");
  const Eigen::Affine3d T_world_file = placement(config.position_m, config.yaw_deg, config.scale);
  for (Eigen::Vector3d& point : points_m) point = T_world_file * point;
  Mesh mesh;
  try {
    mesh = voxelize(points_m, config.leaf_m, config.min_points);
  } catch (const InputError& problem) {
    reject_file(config.file, problem.what());
  }
  if (mesh.triangles.empty()) {
    reject_file(config.file, "expected a voxel with min_points = " + std::to_string(config.min_points) +
                                 " points at this leaf_m, found none");
  }
  SceneBuilder scene;
  scene.add(std::move(mesh), {"cloud", static_cast<float>(config.reflectivity), false, {0.6F, 0.6F, 0.62F}},
            surface_class_of(config.surface_class).value_or(SurfaceClass::kUnlabeled), 1);
  return scene.finish();
}

}  // namespace swiftlet::sim
