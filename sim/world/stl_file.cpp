// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <bit>

#include "sim/world/input_file.hpp"
#include "sim/world/mesh_file.hpp"
#include "sim/world/number_reading.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

// Sizes of the header and of a triangle in a binary STL file.
constexpr std::size_t kHeadBytes = 84, kTriangleBytes = 50;

void add_corner(MeshFile& mesh, const Eigen::Vector3d& vertex) {
  mesh.corners.push_back(static_cast<std::uint32_t>(mesh.vertices_mesh.size()));
  mesh.vertices_mesh.push_back(vertex);
}

/// Ignores lines that begin with words other than solid, vertex and endloop.
MeshFile read_text_stl(std::string_view content) {
  MeshFile mesh;
  std::vector<std::string_view> words;
  TextLines lines(content);
  const auto end_face = [&] {
    mesh.end_face();
    mesh.lines.push_back(lines.number());
  };
  while (lines.next()) {
    split(lines.line(), words);
    if (words.empty()) continue;
    const std::string keyword = lower_case(words[0]);
    if (keyword == "solid") {
      mesh.begin_part({.object = rest_of(lines.line())});
    } else if (keyword == "vertex") {
      words.resize(4);
      add_corner(mesh, {number_or_nan(words[1]), number_or_nan(words[2]), number_or_nan(words[3])});
    } else if (keyword == "endloop") {
      end_face();
    }
  }
  // A truncated file ends within a loop.
  if (mesh.corners.size() > (mesh.faces_end.empty() ? 0 : mesh.faces_end.back())) end_face();
  return mesh;
}

MeshFile read_binary_stl(const fs::path& file, std::string_view content) {
  if (content.size() < kHeadBytes)
    reject_file(file, "truncated: expected 84 bytes of STL header, found " + std::to_string(content.size()));
  constexpr bool kSwap = std::endian::native == std::endian::big;
  const auto count = static_cast<std::uint64_t>(decode(content.data() + 80, 'u', 4, kSwap));
  const std::uint64_t expected = kHeadBytes + kTriangleBytes * count;
  if (content.size() < expected) {
    reject_file(file, "truncated: expected " + std::to_string(expected) + " bytes for " + std::to_string(count) +
                          " triangles, found " + std::to_string(content.size()) + " (a text begins with 'solid')");
  }
  MeshFile mesh;
  mesh.begin_part({});
  for (std::uint64_t i = 0; i < count; ++i) {
    const char* number = content.data() + kHeadBytes + kTriangleBytes * i + 12;  // after the normal
    for (int corner = 0; corner < 3; ++corner, number += 12) {
      add_corner(mesh,
                 {decode(number, 'f', 4, kSwap), decode(number + 4, 'f', 4, kSwap), decode(number + 8, 'f', 4, kSwap)});
    }
    mesh.end_face();
  }
  return mesh;
}

}  // namespace

MeshFile read_stl(const fs::path& file, std::string_view content) {
  const std::string_view text = without_mark(content);
  const std::size_t begin = std::min(text.find_first_not_of(" \t\r\n"), text.size());
  // The header of a binary file may also begin with "solid", but it contains zero bytes, unlike a text.
  const bool is_text = lower_case(text.substr(begin, 5)) == "solid" && content.find('\0') == std::string_view::npos;
  return is_text ? read_text_stl(text) : read_binary_stl(file, content);
}

}  // namespace swiftlet::sim
