// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Meshes of other programs: one reader for each format, one rule for what is wrong with a face.
namespace swiftlet::sim {

/// Vertices and faces as a file lists them, in its units and axes. Nothing is placed or triangulated yet.
struct MeshFile {
  /// Corner that names no vertex.
  static constexpr std::uint32_t kNoVertex = 0xFFFFFFFF;

  /// Faces that share their names.
  struct Part {
    std::string object = {}, group = {}, material = {};  ///< empty: the file gives none
    Eigen::Vector3f color_rgb = {0.6F, 0.6F, 0.6F};
    std::size_t first_face = 0;  ///< the part ends where the next one begins
  };

  std::vector<Eigen::Vector3d> vertices_mesh;  ///< NaN where the file has no number
  std::vector<Part> parts;                     ///< in the order of their faces
  std::vector<std::uint32_t> corners;          ///< of all faces, one after the other
  std::vector<std::size_t> faces_end;          ///< of each face in `corners`
  std::vector<std::size_t> lines;              ///< of each face; empty for binary files and PLY, which count faces

  std::size_t num_faces() const { return faces_end.size(); }
  std::span<const std::uint32_t> face(std::size_t i) const;
  /// "line 12" or "face 3".
  std::string place_of(std::size_t face) const;
  void begin_part(Part part);
  /// Ends the face of the corners since the last one.
  void end_face() { faces_end.push_back(corners.size()); }
};

/// Wavefront OBJ with the names and colors of its materials (MTL). Normals, textures, lines and points are passed over.
MeshFile read_obj(const std::filesystem::path& file, std::string_view content);
/// PLY, text or binary of either byte order.
MeshFile read_ply_mesh(const std::filesystem::path& file, std::string_view content);
/// STL, text or binary.
MeshFile read_stl(const std::filesystem::path& file, std::string_view content);

/// Cuts a face into triangles. Corners that repeat the one before are left out.
/// @return  why the face has no triangle; null when it has
const char* append_triangles(const MeshFile& mesh, std::size_t face,
                             std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace swiftlet::sim
