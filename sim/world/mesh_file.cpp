// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/mesh_file.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

namespace swiftlet::sim {
namespace {

using Eigen::Vector3d;

/// Largest number of corners of a non-convex face. The cost grows with the square or cube of this number.
constexpr std::size_t kMaxConcaveCorners = 1000;

/// A face without repeated corners, and twice its area as a vector.
class Polygon {
 public:
  Polygon(const MeshFile& mesh, std::vector<std::uint32_t> corners) : mesh_(mesh), corners_(std::move(corners)) {
    for (std::size_t i = 1; i + 1 < corners_.size(); ++i) normal_ += (at(i) - at(0)).cross(at(i + 1) - at(0));
  }

  std::size_t size() const { return corners_.size(); }
  bool has_area() const { return normal_.squaredNorm() > 0.0; }
  bool is_convex() const {
    for (std::size_t i = 0; i < size(); ++i) {
      if (turn(i, next(i), next(next(i))) < 0.0) return false;
    }
    return true;
  }

  /// Removes a corner and returns its triangle.
  std::array<std::uint32_t, 3> cut(std::size_t i) {
    const std::array<std::uint32_t, 3> triangle = {corners_[before(i)], corners_[i], corners_[next(i)]};
    corners_.erase(corners_.begin() + static_cast<std::ptrdiff_t>(i));
    return triangle;
  }

  /// A corner whose triangle lies inside the face and contains no other corner [Meisters 1975]; 1 if none.
  std::size_t ear() const {
    for (std::size_t k = 1; k <= size(); ++k) {
      if (is_ear(k % size())) return k % size();
    }
    return 1;
  }

  const std::vector<std::uint32_t>& corners() const { return corners_; }

 private:
  Vector3d at(std::size_t i) const { return mesh_.vertices_mesh[corners_[i]]; }
  std::size_t next(std::size_t i) const { return i + 1 == size() ? 0 : i + 1; }
  std::size_t before(std::size_t i) const { return i == 0 ? size() - 1 : i - 1; }
  /// Positive when a, b, c turn in the orientation of the face.
  double turn(std::size_t a, std::size_t b, std::size_t c) const {
    return (at(b) - at(a)).cross(at(c) - at(b)).dot(normal_);
  }
  bool is_ear(std::size_t i) const {
    const std::size_t a = before(i), c = next(i);
    if (turn(a, i, c) <= 0.0) return false;
    for (std::size_t k = next(c); k != a; k = next(k)) {
      const bool is_corner = corners_[k] == corners_[a] || corners_[k] == corners_[i] || corners_[k] == corners_[c];
      if (!is_corner && turn(a, i, k) >= 0.0 && turn(i, c, k) >= 0.0 && turn(c, a, k) >= 0.0) return false;
    }
    return true;
  }

  const MeshFile& mesh_;
  std::vector<std::uint32_t> corners_;
  Vector3d normal_ = Vector3d::Zero();
};

}  // namespace

std::span<const std::uint32_t> MeshFile::face(std::size_t i) const {
  const std::size_t begin = i == 0 ? 0 : faces_end[i - 1];
  return std::span(corners).subspan(begin, faces_end[i] - begin);
}

std::string MeshFile::place_of(std::size_t face) const {
  return lines.empty() ? "face " + std::to_string(face) : "line " + std::to_string(lines[face]);
}

void MeshFile::begin_part(Part part) {
  part.first_face = num_faces();
  parts.push_back(std::move(part));
}

const char* append_triangles(const MeshFile& mesh, std::size_t face,
                             std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<std::uint32_t> corners;
  for (const std::uint32_t corner : mesh.face(face)) {
    if (corner >= mesh.vertices_mesh.size()) return "a corner names a vertex that does not exist";
    if (!mesh.vertices_mesh[corner].allFinite()) return "a vertex lacks three finite coordinates";
    if (corners.empty() || corner != corners.back()) corners.push_back(corner);
  }
  while (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
  if (corners.size() < 3) return "fewer than three different corners";
  Polygon polygon(mesh, std::move(corners));
  if (!polygon.has_area()) return "the face has no area";
  const bool is_convex = polygon.is_convex();
  if (!is_convex && polygon.size() > kMaxConcaveCorners) return "more than 1000 corners and not convex";
  if (is_convex) {
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
      triangles.push_back({polygon.corners()[0], polygon.corners()[i], polygon.corners()[i + 1]});
    return nullptr;
  }
  while (polygon.size() > 3) triangles.push_back(polygon.cut(polygon.ear()));
  triangles.push_back({polygon.corners()[0], polygon.corners()[1], polygon.corners()[2]});
  return nullptr;
}

}  // namespace swiftlet::sim
