// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/render_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <unordered_map>

namespace swiftlet::sim {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Vector3f = Eigen::Vector3f;

// [-] Triangles of a chunk. Smaller chunks are culled more exactly with more draw calls.
constexpr std::size_t kChunkTriangles = 4096;
constexpr float kCosCrease = 0.74F;        // cosine of 42 deg: flatter edges are shaded smoothly
constexpr std::size_t kLeafTriangles = 4;  // largest size of a connected piece that is a leaf
constexpr float kCrownSize_m = 25.0F;      // larger extents of leaves are not a single crown

Vector3f scaled_normal(const Mesh& mesh, const Triangle& t) {
  const Vector3f& a = mesh.vertices_mesh_m[t[0]];
  return (mesh.vertices_mesh_m[t[1]] - a).cross(mesh.vertices_mesh_m[t[2]] - a);
}

std::array<std::int8_t, 4> pack_normal(const Vector3f& normal, float openness) {
  const float length = normal.norm();
  const Vector3f n = length > 0.0F ? Vector3f(normal / length) : Vector3f::UnitZ();
  const auto to_byte = [](float value) {
    return static_cast<std::int8_t>(std::lround(127.0F * std::clamp(value, -1.0F, 1.0F)));
  };
  return {to_byte(n.x()), to_byte(n.y()), to_byte(n.z()), to_byte(openness)};
}

/// For every vertex, the number of the first vertex at the same position.
std::vector<std::uint32_t> weld(const std::vector<Vector3f>& vertices) {
  struct Hash {
    std::size_t operator()(const std::array<std::uint32_t, 3>& key) const {
      std::uint64_t h = key[0] * 0x9E3779B97F4A7C15ULL;
      h = (h ^ (h >> 29) ^ key[1]) * 0xBF58476D1CE4E5B9ULL;
      h = (h ^ (h >> 32) ^ key[2]) * 0x94D049BB133111EBULL;
      return static_cast<std::size_t>(h ^ (h >> 31));
    }
  };
  std::unordered_map<std::array<std::uint32_t, 3>, std::uint32_t, Hash> first_at;
  first_at.reserve(vertices.size());
  std::vector<std::uint32_t> welded(vertices.size());
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    const Vector3f p = vertices[i] + Vector3f::Zero();  // -0 becomes 0
    std::array<std::uint32_t, 3> key;
    std::memcpy(key.data(), p.data(), sizeof(key));
    welded[i] = first_at.emplace(key, i).first->second;
  }
  return welded;
}

/// Groups of triangles that are not separated (a leaf, or one triangle), as lists of triangle numbers.
struct Groups {
  std::vector<std::uint32_t> first;  // (num_groups + 1), indices into triangles
  std::vector<std::uint32_t> triangles;
  std::size_t size() const { return first.size() - 1; }
};

Groups connected_groups(const Mesh& mesh, const std::vector<std::uint32_t>& pieces) {
  const std::size_t n = mesh.triangles.size();
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return pieces[mesh.triangles[a][0]] < pieces[mesh.triangles[b][0]];
  });
  Groups groups;
  for (std::uint32_t i = 0; i < n; ++i) {
    if (i == 0 || pieces[mesh.triangles[order[i]][0]] != pieces[mesh.triangles[order[i - 1]][0]])
      groups.first.push_back(i);
  }
  groups.first.push_back(static_cast<std::uint32_t>(n));
  groups.triangles = std::move(order);
  return groups;
}

/// Length of each group: the diagonal of its bounding box.
std::vector<float> lengths_of(const Mesh& mesh, const Groups& groups) {
  std::vector<float> lengths_m(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g) {
    Eigen::AlignedBox3f box;
    for (std::uint32_t k = groups.first[g]; k < groups.first[g + 1]; ++k) {
      for (const std::uint32_t v : mesh.triangles[groups.triangles[k]]) box.extend(mesh.vertices_mesh_m[v]);
    }
    lengths_m[g] = box.diagonal().norm();
  }
  return lengths_m;
}

double area_of(const Mesh& mesh) {
  double area_m2 = 0.0;
  for (const Triangle& t : mesh.triangles) area_m2 += 0.5 * scaled_normal(mesh, t).norm();
  return area_m2;
}

Groups single_triangles(std::size_t n) {
  Groups groups;
  groups.first.resize(n + 1);
  groups.triangles.resize(n);
  std::iota(groups.first.begin(), groups.first.end(), 0U);
  std::iota(groups.triangles.begin(), groups.triangles.end(), 0U);
  return groups;
}

/// Splits groups recursively at the median of the longest axis until each part is small; appends the parts in order.
void split(std::vector<std::uint32_t>& groups, std::size_t begin, std::size_t end, std::size_t limit,
           const std::vector<Vector3f>& centers, std::vector<std::pair<std::size_t, std::size_t>>& parts) {
  if (end - begin <= limit) {
    parts.emplace_back(begin, end);
    return;
  }
  Eigen::AlignedBox3f box;
  for (std::size_t i = begin; i < end; ++i) box.extend(centers[groups[i]]);
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::size_t middle = begin + (end - begin) / 2;
  std::nth_element(groups.begin() + begin, groups.begin() + middle, groups.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     return std::pair(centers[a][axis], a) < std::pair(centers[b][axis], b);
                   });
  split(groups, begin, middle, limit, centers, parts);
  split(groups, middle, end, limit, centers, parts);
}

/// Deterministic shuffle, equal for equal lengths.
void shuffle(std::vector<std::uint32_t>& values, std::size_t begin, std::size_t end) {
  std::uint64_t state = 0x9E3779B97F4A7C15ULL;
  for (std::size_t i = end; i > begin + 1; --i) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    std::swap(values[i - 1], values[begin + (state >> 33) % (i - begin)]);
  }
}

/// Leaf vertices: shaded by the shape of their crown, darker inside.
void make_leaf_vertices(const Mesh& mesh, const Groups& leaves, RenderMesh& out) {
  Eigen::AlignedBox3f crown;
  for (const Vector3f& p : mesh.vertices_mesh_m) crown.extend(p);
  const bool is_crown = crown.sizes().head<2>().maxCoeff() < kCrownSize_m;
  const Vector3f center = crown.center() - Vector3f(0, 0, 0.15F * crown.sizes().z());
  const Vector3f half = (0.5F * crown.sizes()).cwiseMax(0.05F);

  out.vertices.reserve(mesh.vertices_mesh_m.size());
  std::vector<std::uint32_t> renumbered(mesh.vertices_mesh_m.size());
  for (std::size_t g = 0; g < leaves.size(); ++g) {
    // Center of the leaf and the mean of its normals, oriented upwards.
    Vector3f middle = Vector3f::Zero();
    Vector3f normal = Vector3f::Zero();
    const std::uint32_t begin = leaves.first[g];
    const std::uint32_t end = leaves.first[g + 1];
    for (std::uint32_t k = begin; k < end; ++k) {
      const Triangle& t = mesh.triangles[leaves.triangles[k]];
      for (const std::uint32_t v : t) middle += mesh.vertices_mesh_m[v];
      const Vector3f n = scaled_normal(mesh, t);
      normal += n.z() < 0.0F ? Vector3f(-n) : n;
    }
    middle /= static_cast<float>(3 * (end - begin));
    normal.normalize();
    const Vector3f from_center = (middle - center).cwiseQuotient(half);
    const Vector3f outward = is_crown ? Vector3f(from_center.cwiseQuotient(half).normalized()) : Vector3f::UnitZ();
    const float openness =
        is_crown ? std::clamp(0.25F + 0.6F * from_center.norm() + 0.15F * from_center.z(), 0.2F, 1.0F) : 0.8F;
    const auto normal_open = pack_normal(0.75F * outward + 0.45F * normal, openness);

    for (std::uint32_t k = begin; k < end; ++k) {
      for (const std::uint32_t v : mesh.triangles[leaves.triangles[k]]) {
        if (renumbered[v] != 0) continue;
        RenderVertex vertex{};
        const Vector3f& p = mesh.vertices_mesh_m[v];
        const Vector3f offset = (p - middle) / kLeafUnit_m;
        vertex.position_m = {p.x(), p.y(), p.z()};
        vertex.normal_open = normal_open;
        for (int c = 0; c < 3; ++c)
          vertex.leaf_offset[c] = static_cast<std::int16_t>(std::clamp(offset[c], -32767.0F, 32767.0F));
        out.vertices.push_back(vertex);
        renumbered[v] = static_cast<std::uint32_t>(out.vertices.size());  // from 1
      }
    }
  }
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) out.indices.push_back(renumbered[v] - 1);
  }
}

/// Vertices of other surfaces: the normal at a corner is the mean over adjacent triangles that are not beyond a crease.
void make_solid_vertices(const Mesh& mesh, const std::vector<std::uint32_t>& welded, RenderMesh& out) {
  const std::size_t num_vertices = mesh.vertices_mesh_m.size();
  std::vector<Vector3f> face_normals(mesh.triangles.size());
  std::vector<std::uint32_t> first(num_vertices + 1, 0);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    face_normals[f] = scaled_normal(mesh, mesh.triangles[f]);
    for (const std::uint32_t v : mesh.triangles[f]) ++first[welded[v] + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::uint32_t> faces_at(first.back());
  std::vector<std::uint32_t> cursor(first.begin(), first.end() - 1);
  for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
    for (const std::uint32_t v : mesh.triangles[f]) faces_at[cursor[welded[v]]++] = f;
  }

  // Vertices created at one position form a linked list.
  constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  std::vector<std::uint32_t> newest(num_vertices, kNone);
  std::vector<std::uint32_t> next;
  out.indices.reserve(3 * mesh.triangles.size());
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const float length = face_normals[f].norm();
    for (const std::uint32_t corner : mesh.triangles[f]) {
      const std::uint32_t v = welded[corner];
      Vector3f normal = Vector3f::Zero();
      for (std::uint32_t k = first[v]; k < first[v + 1]; ++k) {
        const Vector3f& other = face_normals[faces_at[k]];
        if (other.dot(face_normals[f]) >= kCosCrease * other.norm() * length) normal += other;
      }
      const auto packed = pack_normal(normal, 1.0F);
      std::uint32_t found = newest[v];
      while (found != kNone && out.vertices[found].normal_open != packed) found = next[found];
      if (found == kNone) {
        const Vector3f& p = mesh.vertices_mesh_m[v];
        found = static_cast<std::uint32_t>(out.vertices.size());
        out.vertices.push_back({{p.x(), p.y(), p.z()}, packed, {}});
        next.push_back(newest[v]);
        newest[v] = found;
      }
      out.indices.push_back(found);
    }
  }
}

/// Sorts the triangles into compact chunks of whole groups.
/// @param lengths_m  of the groups, longest first within a chunk; empty: other groups than branches
void sort_into_chunks(const Mesh& mesh, const Groups& groups, bool leafy, const std::vector<float>& lengths_m,
                      RenderMesh& out) {
  std::vector<Vector3f> centers(groups.size());
  std::vector<std::uint32_t> order(groups.size());
  std::iota(order.begin(), order.end(), 0U);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    centers[g] = mesh.vertices_mesh_m[mesh.triangles[groups.triangles[groups.first[g]]][0]];
  }
  const std::size_t limit = std::max<std::size_t>(1, kChunkTriangles * groups.size() / mesh.triangles.size());
  std::vector<std::pair<std::size_t, std::size_t>> parts;
  split(order, 0, order.size(), limit, centers, parts);

  std::vector<std::uint32_t> sorted;
  sorted.reserve(out.indices.size());
  for (const auto& [begin, end] : parts) {
    if (leafy) shuffle(order, begin, end);
    if (!lengths_m.empty()) {
      std::sort(order.begin() + begin, order.begin() + end, [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(-lengths_m[a], a) < std::pair(-lengths_m[b], b);
      });
    }
    RenderChunk chunk;
    chunk.first_index = static_cast<std::uint32_t>(sorted.size());
    for (std::size_t i = begin; i < end; ++i) {
      for (std::uint32_t k = groups.first[order[i]]; k < groups.first[order[i] + 1]; ++k) {
        for (int c = 0; c < 3; ++c) {
          const std::uint32_t index = out.indices[3 * groups.triangles[k] + c];
          sorted.push_back(index);
          chunk.box_m.extend(Vector3f(out.vertices[index].position_m.data()));
        }
      }
    }
    chunk.num_indices = static_cast<std::uint32_t>(sorted.size()) - chunk.first_index;
    out.chunks.push_back(chunk);
  }
  out.indices = std::move(sorted);
}

}  // namespace

RenderMesh prepare_mesh(const Mesh& mesh) {
  RenderMesh out;
  if (mesh.triangles.empty()) return out;
  const std::vector<std::uint32_t> welded = weld(mesh.vertices_mesh_m);
  const bool plant =
      mesh.surface_class == SurfaceClass::kVegetation || mesh.surface_class == SurfaceClass::kUndergrowth;
  Groups groups;
  if (plant) {
    groups = connected_groups(mesh, pieces_of(mesh, welded));
    std::size_t in_leaves = 0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const std::size_t size = groups.first[g + 1] - groups.first[g];
      if (size <= kLeafTriangles) in_leaves += size;
    }
    if (4 * in_leaves >= 3 * mesh.triangles.size()) out.leaf_size_m = 1.0F;  // placeholder, computed below
  }
  const bool leafy = out.leaf_size_m > 0.0F;
  if (leafy) {
    make_leaf_vertices(mesh, groups, out);
    out.leaf_size_m = static_cast<float>(std::sqrt(area_of(mesh) / static_cast<double>(groups.size())));
  } else {
    const bool branches = mesh.surface_class == SurfaceClass::kBranch;
    groups = branches ? connected_groups(mesh, pieces_of(mesh, welded)) : single_triangles(mesh.triangles.size());
    make_solid_vertices(mesh, welded, out);
  }
  const std::vector<float> lengths_m =
      mesh.surface_class == SurfaceClass::kBranch ? lengths_of(mesh, groups) : std::vector<float>();
  if (!lengths_m.empty()) {  // the area of a tube is pi * thickness * length
    const double length_m = std::accumulate(lengths_m.begin(), lengths_m.end(), 0.0);
    out.branch_thickness_m = static_cast<float>(area_of(mesh) / (M_PI * std::max(length_m, 1e-6)));
  }

  sort_into_chunks(mesh, groups, leafy, lengths_m, out);
  return out;
}

Frustum frustum_of(const Eigen::Matrix4f& m) {
  const auto row = [&](int i) { return Eigen::Vector4f(m.row(i).transpose()); };
  return {{row(3) + row(0), row(3) - row(0), row(3) + row(1), row(3) - row(1), row(2), row(3) - row(2)}};
}

bool may_be_seen(const Frustum& frustum, const Eigen::AlignedBox3f& box_m, const Eigen::Affine3f& T_world_mesh) {
  const Vector3f center = T_world_mesh * box_m.center();
  const Vector3f half = 0.5F * box_m.sizes();
  for (const Eigen::Vector4f& plane : frustum.planes) {
    const Vector3f n = plane.head<3>();
    const float reach = (T_world_mesh.linear().transpose() * n).cwiseAbs().dot(half);
    if (n.dot(center) + plane.w() + reach < 0.0F) return false;
  }
  return true;
}

}  // namespace swiftlet::sim
