// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "swiftlet/sim/world/scene.hpp"
#include "tests/support/fnv.hpp"

namespace swiftlet::sim::test {

/// FNV-1a over everything that a scene holds, bit by bit.
inline std::uint64_t hash_of(const Scene& scene) {
  swiftlet::test::Fnv1a hash;
  for (const Material& material : scene.materials) {
    hash.add(material.name.data(), material.name.size());
    hash.add(&material.reflectivity, sizeof material.reflectivity);
  }
  for (const Mesh& mesh : scene.meshes) {
    for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) hash.add(vertex.data(), 3 * sizeof(float));
    hash.add(mesh.triangles.data(), mesh.triangles.size() * sizeof mesh.triangles[0]);
    hash.add(&mesh.material, sizeof mesh.material);
    hash.add(&mesh.surface_class, sizeof mesh.surface_class);
  }
  for (const Instance& instance : scene.instances) {
    hash.add(&instance.mesh, sizeof instance.mesh);
    hash.add(instance.T_world_mesh.matrix().data(), 16 * sizeof(float));
    hash.add(&instance.instance, sizeof instance.instance);
  }
  for (const WorldObject& object : scene.objects) {
    hash.add(&object.instance, sizeof object.instance);
    hash.add(object.kind.data(), object.kind.size());
    hash.add(object.position_world_m.data(), 3 * sizeof(double));
    for (const auto& [key, value] : object.attributes) hash.add(&value, sizeof value);
  }
  return hash.value();
}

inline double attribute(const WorldObject& object, const std::string& key) {
  for (const auto& [name, value] : object.attributes) {
    if (name == key) return value;
  }
  return std::nan("");
}

inline std::vector<WorldObject> objects_of(const Scene& scene, SurfaceClass surface_class) {
  std::vector<WorldObject> found;
  for (const WorldObject& object : scene.objects) {
    if (object.surface_class == surface_class) found.push_back(object);
  }
  return found;
}

struct BruteHit {
  double range_m = 0.0;
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  std::uint16_t instance = 0;
};

/// Moeller and Trumbore (1997), one triangle, both sides.
inline std::optional<double> intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                       const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a;
  const Eigen::Vector3d ac = c - a;
  const Eigen::Vector3d p = direction.cross(ac);
  const double determinant = ab.dot(p);
  if (std::abs(determinant) < 1e-15) return std::nullopt;
  const Eigen::Vector3d from_a = origin - a;
  const double u = from_a.dot(p) / determinant;
  const Eigen::Vector3d q = from_a.cross(ab);
  const double v = direction.dot(q) / determinant;
  const double range = ac.dot(q) / determinant;
  if (u < 0 || v < 0 || u + v > 1 || range <= 0) return std::nullopt;
  return range;
}

/// Nearest hit by trying every triangle of the scene.
inline std::optional<BruteHit> trace(const Scene& scene, const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction) {
  std::optional<BruteHit> nearest;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    const Eigen::Affine3d T = instance.T_world_mesh.cast<double>();
    for (const auto& [i, j, k] : mesh.triangles) {
      const auto range_m =
          intersect(origin, direction, T * mesh.vertices_mesh_m[i].cast<double>(),
                    T * mesh.vertices_mesh_m[j].cast<double>(), T * mesh.vertices_mesh_m[k].cast<double>());
      if (range_m && (!nearest || *range_m < nearest->range_m))
        nearest = {*range_m, mesh.surface_class, instance.instance};
    }
  }
  return nearest;
}

/// Free width at a point: ranges to both sides along a direction.
inline double free_width_m(const Scene& scene, const Eigen::Vector3d& point, const Eigen::Vector3d& direction) {
  const auto ahead = trace(scene, point, direction);
  const auto behind = trace(scene, point, -direction);
  return ahead && behind ? ahead->range_m + behind->range_m : std::numeric_limits<double>::infinity();
}

/// World bounding box of each instance number of a class.
inline std::map<std::uint16_t, Eigen::AlignedBox3d> bounds_of_each(const Scene& scene, SurfaceClass surface_class) {
  std::map<std::uint16_t, Eigen::AlignedBox3d> bounds;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (mesh.surface_class != surface_class) continue;
    for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m)
      bounds[instance.instance].extend((instance.T_world_mesh * vertex).cast<double>());
  }
  return bounds;
}

/// Bounding box of all instances of a class.
inline Eigen::AlignedBox3d bounds_of(const Scene& scene, SurfaceClass surface_class) {
  Eigen::AlignedBox3d all;
  for (const auto& [instance, bounds] : bounds_of_each(scene, surface_class)) all.extend(bounds);
  return all;
}

/// Evenly distributed between two values: none beyond them, some near both, and the mean and the variance in between.
inline void expect_uniform(std::vector<double> values, double low, double high, double slack = 1e-5) {
  ASSERT_GE(values.size(), 30U);
  const double n = static_cast<double>(values.size()), width = high - low;
  std::sort(values.begin(), values.end());
  EXPECT_GE(values.front(), low - slack);
  EXPECT_LE(values.back(), high + slack);
  EXPECT_LE(values.front(), low + 12.0 / n * width + slack);  // exp(-12): one of 160 000
  EXPECT_GE(values.back(), high - 12.0 / n * width - slack);
  double sum = 0.0, sum_of_squares = 0.0;
  for (const double value : values) {
    const double share = (value - low) / width;
    sum += share / n, sum_of_squares += share * share / n;
  }
  EXPECT_NEAR(sum, 0.5, 5.0 * std::sqrt(1.0 / 12.0 / n));
  EXPECT_NEAR(sum_of_squares, 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0 / n));
}

/// Checks a count out of n against a probability.
inline void expect_share(double count, double n, double probability) {
  EXPECT_NEAR(count, probability * n, 5.0 * std::sqrt(n * probability * (1.0 - probability)) + 1e-9);
}

}  // namespace swiftlet::sim::test
