// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>
#include <map>

#include "sim/world/input_file.hpp"
#include "sim/world/mesh_file.hpp"
#include "sim/world/number_reading.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using Colors = std::map<std::string, Eigen::Vector3f>;

double coordinate(const std::vector<std::string_view>& words, std::size_t i) {
  return number_or_nan(i < words.size() ? words[i] : std::string_view());
}

/// Vertex index of a corner 7, 7/1, 7//2 or 7/1/2. Negative numbers count back from the latest vertex.
std::uint32_t vertex_named(std::string_view word, std::size_t num_vertices) {
  std::int64_t number = 0;
  const char* const end = word.data() + word.size();
  const auto [at, problem] = std::from_chars(word.data(), end, number);
  if (problem != std::errc() || (at != end && *at != '/')) return MeshFile::kNoVertex;
  if (number < 0) number += static_cast<std::int64_t>(num_vertices) + 1;
  return number >= 1 && number < MeshFile::kNoVertex ? static_cast<std::uint32_t>(number - 1) : MeshFile::kNoVertex;
}

/// Reads a material library; a missing one leaves its materials gray.
void read_colors(const fs::path& file, Colors& colors) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return;
  const std::string content = read_whole_file(file);
  std::vector<std::string_view> words;
  std::string name;
  for (TextLines lines(without_mark(content)); lines.next();) {
    split(lines.line(), words);
    if (words.empty()) continue;
    if (words[0] == "newmtl") name = rest_of(lines.line());
    if (words[0] != "Kd") continue;
    const Eigen::Vector3d color(coordinate(words, 1), coordinate(words, 2), coordinate(words, 3));
    if (color.allFinite()) colors[name] = color.cast<float>();
  }
}

}  // namespace

MeshFile read_obj(const fs::path& file, std::string_view content) {
  MeshFile mesh;
  MeshFile::Part part;         // properties of the following faces
  bool part_is_begun = false;  // already added to the mesh
  Colors colors;
  std::string line;
  std::vector<std::string_view> words;
  for (TextLines lines(without_mark(content)); lines.next();) {
    const std::size_t number = lines.number();
    line = lines.line();
    while (line.ends_with('\\') && !line.starts_with('#') && lines.next())
      line.replace(line.size() - 1, 1, " ").append(lines.line());
    split(std::string_view(line).substr(0, line.find('#')), words);
    if (words.empty()) continue;
    if (words[0] == "v") {
      mesh.vertices_mesh.emplace_back(coordinate(words, 1), coordinate(words, 2), coordinate(words, 3));
    } else if (words[0] == "f") {
      if (!part_is_begun) mesh.begin_part(part);
      part_is_begun = true;
      for (std::size_t i = 1; i < words.size(); ++i)
        mesh.corners.push_back(vertex_named(words[i], mesh.vertices_mesh.size()));
      mesh.end_face();
      mesh.lines.push_back(number);
    } else if (words[0] == "o" || words[0] == "g" || words[0] == "usemtl") {
      part_is_begun = false;
      if (words[0] == "usemtl") {
        part.material = rest_of(line);
      } else if (words[0] == "g") {
        part.group = rest_of(line);
      } else {
        part.object = rest_of(line);
        part.group.clear();
      }
    } else if (words[0] == "mtllib") {
      read_colors(file.parent_path() / rest_of(line), colors);
    }
  }
  for (MeshFile::Part& with_faces : mesh.parts) {
    const auto color = colors.find(with_faces.material);
    if (color != colors.end()) with_faces.color_rgb = color->second;
  }
  return mesh;
}

}  // namespace swiftlet::sim
