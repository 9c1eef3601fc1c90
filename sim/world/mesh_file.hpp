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

/// Meshes of other programs: one reader per format, and common rules for invalid faces.
namespace swiftlet::sim {

/// Vertices and faces in the units and axes of the file, neither placed nor triangulated.
struct MeshFile {
  /// Corner without a valid vertex.
  static constexpr std::uint32_t kNoVertex = 0xFFFFFFFF;

  /// Faces that share object, group and material.
  struct Part {
    std::string object = {}, group = {}, material = {};  ///< empty: not given by the file
    Eigen::Vector3f color_rgb = {0.6F, 0.6F, 0.6F};
    std::size_t first_face = 0;  ///< the part ends at the first face of the next one
  };

  std::vector<Eigen::Vector3d> vertices_mesh;  ///< NaN for an invalid number
  std::vector<Part> parts;                     ///< in the order of their faces
  std::vector<std::uint32_t> corners;          ///< vertex indices of all faces in sequence
  std::vector<std::size_t> faces_end;          ///< end of each face in `corners`
  std::vector<std::size_t> lines;              ///< line of each face; empty for binary files and PLY, which count faces

  std::size_t num_faces() const { return faces_end.size(); }
  std::span<const std::uint32_t> face(std::size_t i) const;
  /// Location for messages: "line 12" or "face 3".
  std::string place_of(std::size_t face) const;
  void begin_part(Part part);
  /// Ends the face that consists of the corners added since the last one.
  void end_face() { faces_end.push_back(corners.size()); }
};

/// Wavefront OBJ with material names and colors (MTL). Normals, textures, lines and points are ignored.
MeshFile read_obj(const std::filesystem::path& file, std::string_view content);
/// PLY, text or binary of either byte order.
MeshFile read_ply_mesh(const std::filesystem::path& file, std::string_view content);
/// STL, text or binary.
MeshFile read_stl(const std::filesystem::path& file, std::string_view content);

/// Triangulates a face. Corners equal to their predecessor are omitted.
/// @return the reason why the face has no triangle; null on success
const char* append_triangles(const MeshFile& mesh, std::size_t face,
                             std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace swiftlet::sim
