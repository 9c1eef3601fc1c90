// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/mesh_builder.hpp"

#include <cmath>
#include <map>
#include <numbers>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3f;

std::uint32_t next_vertex(const Mesh& mesh) { return static_cast<std::uint32_t>(mesh.vertices_mesh_m.size()); }

void add_box_triangles(Mesh& mesh, std::uint32_t first) {
  // Corner i has x, y, z at its maximum where bits 0, 1, 2 are set.
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces = {
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (const auto& face : kFaces) {
    mesh.triangles.push_back({first + face[0], first + face[1], first + face[2]});
    mesh.triangles.push_back({first + face[0], first + face[2], first + face[3]});
  }
}

// Circumradius of the regular polygon with the area of the unit circle.
float equal_area_circumradius(int sides) {
  const double step_rad = 2.0 * std::numbers::pi / sides;
  return static_cast<float>(std::sqrt(step_rad / elementary::sin(step_rad)));
}

Mesh make_unit_icosphere(int subdivisions) {
  Mesh mesh;
  const float phi = static_cast<float>((1.0 + std::sqrt(5.0)) / 2.0);
  mesh.vertices_mesh_m = {{-1, phi, 0},  {1, phi, 0},  {-1, -phi, 0}, {1, -phi, 0}, {0, -1, phi},  {0, 1, phi},
                          {0, -1, -phi}, {0, 1, -phi}, {phi, 0, -1},  {phi, 0, 1},  {-phi, 0, -1}, {-phi, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (Vector3f& vertex : mesh.vertices_mesh_m) vertex.normalize();
  for (int i = 0; i < subdivisions; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [place, is_new] = middles.try_emplace(std::minmax(a, b), next_vertex(mesh));
      if (is_new) mesh.vertices_mesh_m.push_back((mesh.vertices_mesh_m[a] + mesh.vertices_mesh_m[b]).normalized());
      return place->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    finer.reserve(4 * mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b);
      const std::uint32_t bc = middle(b, c);
      const std::uint32_t ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  const double to_unit_volume = elementary::cbrt(4.0 / 3.0 * std::numbers::pi / signed_volume_m3(mesh));
  for (Vector3f& vertex : mesh.vertices_mesh_m) vertex *= static_cast<float>(to_unit_volume);
  return mesh;
}

}  // namespace

void add_triangle(Mesh& mesh, const Vector3f& a, const Vector3f& b, const Vector3f& c) {
  const std::uint32_t first = next_vertex(mesh);
  mesh.vertices_mesh_m.insert(mesh.vertices_mesh_m.end(), {a, b, c});
  mesh.triangles.push_back({first, first + 1, first + 2});
}

void add_quad(Mesh& mesh, const Vector3f& a, const Vector3f& b, const Vector3f& c, const Vector3f& d) {
  const std::uint32_t first = next_vertex(mesh);
  mesh.vertices_mesh_m.insert(mesh.vertices_mesh_m.end(), {a, b, c, d});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

void add_box(Mesh& mesh, const Vector3f& min_m, const Vector3f& max_m) {
  const std::uint32_t first = next_vertex(mesh);
  for (int i = 0; i < 8; ++i) {
    mesh.vertices_mesh_m.emplace_back(i & 1 ? max_m.x() : min_m.x(), i & 2 ? max_m.y() : min_m.y(),
                                      i & 4 ? max_m.z() : min_m.z());
  }
  add_box_triangles(mesh, first);
}

void add_box(Mesh& mesh, const Eigen::Affine3f& T, const Vector3f& size_m) {
  const std::uint32_t first = next_vertex(mesh);
  for (int i = 0; i < 8; ++i) {
    const Vector3f sign(i & 1 ? 0.5F : -0.5F, i & 2 ? 0.5F : -0.5F, i & 4 ? 0.5F : -0.5F);
    mesh.vertices_mesh_m.push_back(T * sign.cwiseProduct(size_m));
  }
  add_box_triangles(mesh, first);
}

void add_tube(Mesh& mesh, std::span<const Vector3f> points_m, std::span<const float> radii_m, int sides, Caps caps) {
  const std::uint32_t first = next_vertex(mesh);
  const auto num_rings = static_cast<std::uint32_t>(points_m.size());
  const auto num_sides = static_cast<std::uint32_t>(sides);
  const float circumradius = equal_area_circumradius(sides);
  const float step_rad = 2.0F * std::numbers::pi_v<float> / static_cast<float>(sides);

  // The frame (side, up) is propagated along the polyline, so that the tube does not twist.
  Vector3f side = (points_m[1] - points_m[0]).unitOrthogonal();
  for (std::uint32_t ring = 0; ring < num_rings; ++ring) {
    const Vector3f& before = points_m[ring == 0 ? 0 : ring - 1];
    const Vector3f& after = points_m[ring + 1 == num_rings ? ring : ring + 1];
    const Vector3f axis = (after - before).normalized();
    side = (side - side.dot(axis) * axis).normalized();
    const Vector3f up = axis.cross(side);
    for (std::uint32_t k = 0; k < num_sides; ++k) {
      const float angle_rad = step_rad * static_cast<float>(k);
      const Vector3f radial = elementary::cos(angle_rad) * side + elementary::sin(angle_rad) * up;
      mesh.vertices_mesh_m.push_back(points_m[ring] + circumradius * radii_m[ring] * radial);
    }
  }
  for (std::uint32_t ring = 0; ring + 1 < num_rings; ++ring) {
    const std::uint32_t low = first + ring * num_sides;
    const std::uint32_t high = low + num_sides;
    for (std::uint32_t k = 0; k < num_sides; ++k) {
      const std::uint32_t next = (k + 1) % num_sides;
      mesh.triangles.push_back({low + k, low + next, high + next});
      mesh.triangles.push_back({low + k, high + next, high + k});
    }
  }
  const std::uint32_t last = first + (num_rings - 1) * num_sides;
  for (std::uint32_t k = 1; k + 1 < num_sides; ++k) {
    if (caps == Caps::kStart || caps == Caps::kBoth) mesh.triangles.push_back({first, first + k + 1, first + k});
    if (caps == Caps::kEnd || caps == Caps::kBoth) mesh.triangles.push_back({last, last + k, last + k + 1});
  }
}

void add_frustum(Mesh& mesh, const Vector3f& from_m, float radius_from_m, const Vector3f& to_m, float radius_to_m,
                 int sides, Caps caps) {
  const std::array<Vector3f, 2> points_m = {from_m, to_m};
  const std::array<float, 2> radii_m = {radius_from_m, radius_to_m};
  add_tube(mesh, points_m, radii_m, sides, caps);
}

void add_icosphere(Mesh& mesh, const Vector3f& center_m, float radius_m, int subdivisions) {
  Eigen::Affine3f T = Eigen::Affine3f::Identity();
  T.translate(center_m).scale(radius_m);
  append(mesh, make_unit_icosphere(subdivisions), T);
}

void add_heightfield(Mesh& mesh, const Eigen::Vector2f& origin_m, const Eigen::Vector2f& cell_m, int columns, int rows,
                     std::span<const float> heights_m) {
  const std::uint32_t first = next_vertex(mesh);
  const auto at = [&](int column, int row) { return first + static_cast<std::uint32_t>(row * columns + column); };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      mesh.vertices_mesh_m.emplace_back(origin_m.x() + cell_m.x() * static_cast<float>(column),
                                        origin_m.y() + cell_m.y() * static_cast<float>(row),
                                        heights_m[static_cast<std::size_t>(row) * columns + column]);
    }
  }
  for (int row = 0; row + 1 < rows; ++row) {
    for (int column = 0; column + 1 < columns; ++column) {
      mesh.triangles.push_back({at(column, row), at(column + 1, row), at(column + 1, row + 1)});
      mesh.triangles.push_back({at(column, row), at(column + 1, row + 1), at(column, row + 1)});
    }
  }
}

void append(Mesh& mesh, const Mesh& other, const Eigen::Affine3f& T) {
  const std::uint32_t first = next_vertex(mesh);
  for (const Vector3f& vertex : other.vertices_mesh_m) mesh.vertices_mesh_m.push_back(T * vertex);
  for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({first + a, first + b, first + c});
}

double signed_volume_m3(const Mesh& mesh) {
  double volume_m3 = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d p = mesh.vertices_mesh_m[a].cast<double>();
    const Eigen::Vector3d q = mesh.vertices_mesh_m[b].cast<double>();
    const Eigen::Vector3d r = mesh.vertices_mesh_m[c].cast<double>();
    volume_m3 += p.dot(q.cross(r)) / 6.0;
  }
  return volume_m3;
}

double area_m2(const Mesh& mesh) {
  double area = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3f& origin = mesh.vertices_mesh_m[a];
    area += 0.5 * (mesh.vertices_mesh_m[b] - origin).cross(mesh.vertices_mesh_m[c] - origin).norm();
  }
  return area;
}

Eigen::AlignedBox3f bounds_m(const Mesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const Vector3f& vertex : mesh.vertices_mesh_m) box.extend(vertex);
  return box;
}

}  // namespace swiftlet::sim
