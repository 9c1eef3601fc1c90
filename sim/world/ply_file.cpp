// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/ply_file.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <sstream>

#include "sim/world/input_file.hpp"
#include "sim/world/number_reading.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMaxHeaderBytes = 1 << 20;

bool parse_type(const std::string& word, char& kind, int& size) {
  struct Name {
    const char* word;
    char kind;
    int size;
  };
  constexpr Name kNames[] = {{"char", 'i', 1},  {"int8", 'i', 1},    {"uchar", 'u', 1},  {"uint8", 'u', 1},
                             {"short", 'i', 2}, {"int16", 'i', 2},   {"ushort", 'u', 2}, {"uint16", 'u', 2},
                             {"int", 'i', 4},   {"int32", 'i', 4},   {"uint", 'u', 4},   {"uint32", 'u', 4},
                             {"float", 'f', 4}, {"float32", 'f', 4}, {"double", 'f', 8}, {"float64", 'f', 8}};
  for (const Name& name : kNames) {
    if (word == name.word) {
      kind = name.kind;
      size = name.size;
      return true;
    }
  }
  return false;
}

PlyHeader::Property parse_property(const fs::path& file, std::istringstream& words, const std::string& line) {
  PlyHeader::Property property;
  std::string type;
  words >> type;
  if (type == "list") {
    property.is_list = true;
    std::string count_type;
    words >> count_type >> type;
    if (!parse_type(count_type, property.count_kind, property.count_size) || property.count_kind == 'f') {
      reject_file(file, "PLY header: expected a whole-number type for the length of a list, found '" + line + "'");
    }
  }
  if (!parse_type(type, property.kind, property.size))
    reject_file(file, "PLY header: expected a property type, found '" + line + "'");
  if (!(words >> property.name)) reject_file(file, "PLY header: expected a property name, found '" + line + "'");
  return property;
}

// Each value of a text file takes at least a digit and a separator, each binary element its fixed bytes.
void check_length(const fs::path& file, const PlyHeader& header, std::size_t content_bytes) {
  const std::uint64_t available = content_bytes - header.data_begin;
  std::uint64_t needed = 0;
  for (const PlyHeader::Element& element : header.elements) {
    const std::uint64_t each =
        header.format == PlyHeader::Format::kAscii ? 2 * element.properties.size() : element.min_bytes();
    if (each != 0 && element.count > (available + 1) / each)
      needed = available + 2;
    else
      needed += each * element.count;
    if (needed > available + 1) {
      reject_file(file, "truncated: the PLY header promises " + std::to_string(element.count) + " elements '" +
                            element.name + "', the file has " + std::to_string(available) + " bytes of data");
    }
  }
}

/// Takes the values of a PLY file one by one.
class PlyValues {
 public:
  PlyValues(const fs::path& file, const PlyHeader& header, const std::string& content)
      : file_(file),
        is_text_(header.format == PlyHeader::Format::kAscii),
        swap_((header.format == PlyHeader::Format::kBigEndian) != (std::endian::native == std::endian::big)),
        at_(content.data() + header.data_begin),
        end_(content.data() + content.size()),
        words_(content, header.data_begin) {}

  /// All values of a property of the element's row into `values`: one, or those of a list.
  void take(const PlyHeader::Element& element, std::uint64_t row, const PlyHeader::Property& property,
            std::vector<double>& values) {
    std::uint64_t count = 1;
    if (property.is_list) {
      const double length = next(element, row, property, property.count_kind, property.count_size);
      // Nobody makes room for a list before it is known that the file can hold it.
      if (!(length >= 0.0 && length <= static_cast<double>(room_for(property.size)) && length == std::floor(length))) {
        std::ostringstream found;
        found << length;
        reject_file(file_, place(element, row) + ": expected a list '" + property.name +
                               "' that fits into the file, found one of " + found.str() + " values");
      }
      count = static_cast<std::uint64_t>(length);
    }
    values.clear();
    for (std::uint64_t i = 0; i < count; ++i)
      values.push_back(next(element, row, property, property.kind, property.size));
  }

  static std::string place(const PlyHeader::Element& element, std::uint64_t row) {
    return element.name + " " + std::to_string(row);
  }

 private:
  double next(const PlyHeader::Element& element, std::uint64_t row, const PlyHeader::Property& property, char kind,
              int size) {
    if (is_text_) {
      if (const auto number = words_.number()) return *number;
    } else if (end_ - at_ >= size) {
      at_ += size;
      return decode(at_ - size, kind, size, swap_);
    }
    reject_file(file_, (is_text_ ? "expected a number, found none for '" : "truncated: it ends before '") +
                           property.name + "' of " + place(element, row));
  }

  /// What the rest of the file can hold of values of this size: in a text a digit and a blank each.
  std::uint64_t room_for(int value_bytes) const {
    return is_text_ ? (words_.left() + 1) / 2 : static_cast<std::uint64_t>((end_ - at_) / value_bytes);
  }

  const fs::path& file_;
  bool is_text_, swap_;
  const char* at_;
  const char* end_;
  Words words_;
};

void add_vertex(PlyMesh& mesh, const PlyHeader::Property& property, const std::vector<double>& values) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!property.is_list && property.name == std::string(1, "xyz"[axis]))
      mesh.vertices_mesh_m.back()[axis] = static_cast<float>(values[0]);
  }
}

void add_face(PlyMesh& mesh, const PlyHeader::Property& property, const std::vector<double>& values) {
  if (!property.is_list || (property.name != "vertex_indices" && property.name != "vertex_index")) return;
  for (const double corner : values) {
    // What is no number of a vertex becomes one that no vertex has.
    const bool is_index = corner >= 0.0 && corner < 4294967295.0 && corner == std::floor(corner);
    mesh.corners.push_back(is_index ? static_cast<std::uint32_t>(corner) : ~std::uint32_t{0});
  }
}

/// Vertices may come after the faces that name them.
void check_corners(const fs::path& file, const PlyMesh& mesh) {
  for (std::size_t face = 0; face + 1 < mesh.corners_begin.size(); ++face) {
    for (std::size_t i = mesh.corners_begin[face]; i < mesh.corners_begin[face + 1]; ++i) {
      if (mesh.corners[i] >= mesh.vertices_mesh_m.size())
        reject_file(file, "face " + std::to_string(face) + " names a vertex that does not exist");
    }
  }
}

/// Appends a number in the order of bytes of nearly all machines.
template <class Value>
void append_little_endian(std::string& out, Value value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes, bytes + sizeof value);
  out.append(bytes, sizeof value);
}

}  // namespace

bool PlyHeader::Element::has_list() const {
  return std::any_of(properties.begin(), properties.end(), [](const Property& property) { return property.is_list; });
}

std::uint64_t PlyHeader::Element::min_bytes() const {
  std::uint64_t bytes = 0;
  for (const Property& property : properties) bytes += property.is_list ? property.count_size : property.size;
  return bytes;
}

PlyHeader parse_ply_header(const fs::path& file, const std::string& content) {
  PlyHeader header;
  std::size_t position = 0;
  bool has_format = false;
  for (int line_number = 1;; ++line_number) {
    const std::size_t end = content.find('\n', position);
    if (end == std::string::npos || end > kMaxHeaderBytes)
      reject_file(file, "expected a PLY header that ends with 'end_header', found none");
    std::string line = content.substr(position, end - position);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    position = end + 1;
    if (line_number == 1) {
      if (line != "ply") reject_file(file, "expected a PLY file that begins with 'ply'");
      continue;
    }
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "end_header") break;
    if (word == "format") {
      std::string format, version;
      words >> format >> version;
      // Of several the library may believe another one, and then take text for the length of a list.
      if (has_format) reject_file(file, "PLY header: expected one format, found a second one: '" + line + "'");
      if (version != "1.0") reject_file(file, "PLY header: expected a format of version 1.0, found '" + line + "'");
      has_format = true;
      if (format == "ascii")
        header.format = PlyHeader::Format::kAscii;
      else if (format == "binary_little_endian")
        header.format = PlyHeader::Format::kLittleEndian;
      else if (format == "binary_big_endian")
        header.format = PlyHeader::Format::kBigEndian;
      else
        reject_file(file, "PLY header: expected format ascii, binary_little_endian or binary_big_endian, found '" +
                              format + "'");
    } else if (word == "element") {
      PlyHeader::Element element;
      std::string count;
      words >> element.name >> count;
      const auto result = std::from_chars(count.data(), count.data() + count.size(), element.count);
      if (count.empty() || result.ec != std::errc() || result.ptr != count.data() + count.size()) {
        reject_file(file, "PLY header: expected the number of elements, found '" + line + "'");
      }
      header.elements.push_back(std::move(element));
    } else if (word == "property") {
      if (header.elements.empty()) reject_file(file, "PLY header: expected an element before '" + line + "'");
      header.elements.back().properties.push_back(parse_property(file, words, line));
    } else if (!word.empty() && word != "comment" && word != "obj_info") {
      reject_file(file, "PLY header: expected format, element, property, comment or end_header, found '" + line + "'");
    }
  }
  if (!has_format) reject_file(file, "PLY header: expected a format, found none");
  header.data_begin = position;
  check_length(file, header, content.size());
  return header;
}

PlyMesh read_ply_mesh(const fs::path& file, const std::string& content) {
  const PlyHeader header = parse_ply_header(file, content);
  for (const char* needed : {"vertex", "face"}) {
    const bool is_there = std::any_of(header.elements.begin(), header.elements.end(),
                                      [&](const auto& element) { return element.name == needed && element.count > 0; });
    if (!is_there) {
      reject_file(file, std::string("expected a mesh with elements '") + needed +
                            "', found none (a point cloud is a world of type cloud)");
    }
  }
  PlyMesh mesh;
  PlyValues data(file, header, content);
  std::vector<double> values;
  for (const PlyHeader::Element& element : header.elements) {
    if (element.properties.empty()) continue;
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (is_vertex) mesh.vertices_mesh_m.emplace_back(Eigen::Vector3f::Zero());
      if (is_face) mesh.corners_begin.push_back(mesh.corners.size());
      for (const PlyHeader::Property& property : element.properties) {
        data.take(element, row, property, values);
        if (is_vertex) add_vertex(mesh, property, values);
        if (is_face) add_face(mesh, property, values);
      }
    }
  }
  mesh.corners_begin.push_back(mesh.corners.size());
  check_corners(file, mesh);
  return mesh;
}

std::string to_plain_ply(const PlyMesh& mesh) {
  const std::size_t num_faces = mesh.corners_begin.size() - 1;
  std::string out = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                    std::to_string(mesh.vertices_mesh_m.size()) +
                    "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                    std::to_string(num_faces) + "\nproperty list uint int vertex_indices\nend_header\n";
  out.reserve(out.size() + 12 * mesh.vertices_mesh_m.size() + 4 * (num_faces + mesh.corners.size()));
  for (const Eigen::Vector3f& p_mesh_m : mesh.vertices_mesh_m) {
    for (int axis = 0; axis < 3; ++axis) append_little_endian(out, p_mesh_m[axis]);
  }
  for (std::size_t face = 0; face < num_faces; ++face) {
    append_little_endian(out, static_cast<std::uint32_t>(mesh.corners_begin[face + 1] - mesh.corners_begin[face]));
    for (std::size_t i = mesh.corners_begin[face]; i < mesh.corners_begin[face + 1]; ++i)
      append_little_endian(out, mesh.corners[i]);
  }
  return out;
}

}  // namespace swiftlet::sim
