// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

/// PLY files (G. Turk, 1994): text and binary, of either order of bytes.
namespace swiftlet::sim {

/// The head of a PLY file.
struct PlyHeader {
  enum class Format { kAscii, kLittleEndian, kBigEndian };
  struct Property {
    std::string name;
    char kind = 'f';  ///< i: signed, u: unsigned, f: floating
    int size = 4;     ///< bytes
    bool is_list = false;
    char count_kind = 'u';  ///< of a list's length
    int count_size = 0;     ///< its bytes
  };
  struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
    bool has_list() const;
    std::uint64_t min_bytes() const;  ///< of one element in a binary file; lists counted as empty
  };
  Format format = Format::kAscii;
  std::vector<Element> elements;
  std::size_t data_begin = 0;  ///< offset of the first byte after the head
};

/// Reads the head and checks that the file is long enough for what the head promises.
PlyHeader parse_ply_header(const std::filesystem::path& file, const std::string& content);

/// What a mesh needs of a PLY file.
struct PlyMesh {
  std::vector<Eigen::Vector3f> vertices_mesh_m;
  std::vector<std::uint32_t> corners;      ///< of all faces, one after the other
  std::vector<std::size_t> corners_begin;  ///< of each face in `corners`, and at last the end
};

/// Reads vertices and faces. Each number is there, and each corner names a vertex, or else it throws InputError.
PlyMesh read_ply_mesh(const std::filesystem::path& file, const std::string& content);

/// The same mesh as a file of the plainest form: little-endian, vertices of x, y, z, faces of vertex_indices.
std::string to_plain_ply(const PlyMesh& mesh);

}  // namespace swiftlet::sim
