// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/ply_file.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <utility>

#include "sim/world/input_file.hpp"
#include "sim/world/mesh_file.hpp"
#include "sim/world/number_reading.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
// Longest accepted header.
constexpr std::size_t kMaxHeaderBytes = 1 << 20;

bool parse_type(std::string_view word, char& kind, int& size) {
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

/// Parser of the header, line by line.
class HeaderReader {
 public:
  HeaderReader(const fs::path& file, std::string_view content) : file_(file), lines_(content) {}

  PlyHeader read() {
    next_line();
    if (words_.size() != 1 || words_[0] != "ply") reject_file(file_, "expected a PLY file that begins with 'ply'");
    while (true) {
      next_line();
      const std::string_view word = words_.empty() ? "comment" : words_[0];
      if (word == "end_header") break;
      if (word == "format") {
        take_format();
      } else if (word == "element") {
        take_element();
      } else if (word == "property") {
        take_property();
      } else if (word != "comment" && word != "obj_info") {
        reject("format, element, property, comment or end_header");
      }
    }
    if (!has_format_) reject_file(file_, "PLY header: expected a format, found none");
    header_.data_begin = lines_.end();
    return std::move(header_);
  }

 private:
  void next_line() {
    if (!lines_.next() || lines_.end() > kMaxHeaderBytes)
      reject_file(file_, "expected a PLY header that ends with 'end_header', found none");
    split(lines_.line(), words_);
  }
  [[noreturn]] void reject(const std::string& expected) const {
    reject_file(file_, lines_.number(),
                "PLY header: expected " + expected + ", found '" + std::string(lines_.line().substr(0, 60)) + "'");
  }
  std::string_view word(std::size_t i) const { return i < words_.size() ? words_[i] : std::string_view(); }

  void take_format() {
    constexpr std::string_view kFormats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    const auto* const found = std::find(std::begin(kFormats), std::end(kFormats), word(1));
    if (has_format_) reject("one format");
    if (word(2) != "1.0") reject("a format of version 1.0");
    if (found == std::end(kFormats)) reject("format ascii, binary_little_endian or binary_big_endian");
    header_.format = static_cast<PlyHeader::Format>(found - std::begin(kFormats));
    has_format_ = true;
  }

  void take_element() {
    const auto count = number_in<std::uint64_t>(word(2));
    if (!count) reject("the number of elements");
    header_.elements.push_back({std::string(word(1)), *count, {}});
  }

  void take_property() {
    if (header_.elements.empty()) reject("an element before its properties");
    PlyHeader::Property property;
    property.is_list = word(1) == "list";
    if (property.is_list &&
        (!parse_type(word(2), property.count_kind, property.count_size) || property.count_kind == 'f'))
      reject("a whole-number type for the length of a list");
    const std::size_t type = property.is_list ? 3 : 1;
    if (!parse_type(word(type), property.kind, property.size)) reject("a property type");
    property.name = word(type + 1);
    if (property.name.empty()) reject("a property name");
    header_.elements.back().properties.push_back(std::move(property));
  }

  const fs::path& file_;
  TextLines lines_;
  std::vector<std::string_view> words_;
  PlyHeader header_;
  bool has_format_ = false;
};

// Each value of a text file needs at least a digit and a separator, each binary element a fixed number of bytes.
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
      reject_file(file, "truncated: the PLY header announces " + std::to_string(element.count) + " elements '" +
                            element.name + "', the file has " + std::to_string(available) + " bytes of data");
    }
  }
}

/// Sequential reading of values of a PLY file.
class PlyValues {
 public:
  PlyValues(const fs::path& file, const PlyHeader& header, std::string_view content)
      : file_(file),
        is_text_(header.format == PlyHeader::Format::kAscii),
        swap_((header.format == PlyHeader::Format::kBigEndian) != (std::endian::native == std::endian::big)),
        at_(content.data() + header.data_begin),
        end_(content.data() + content.size()),
        words_(content, header.data_begin) {}

  /// Reads all values of a property of the element's row into `values`: one, or those of a list.
  void take(const PlyHeader::Element& element, std::uint64_t row, const PlyHeader::Property& property,
            std::vector<double>& values) {
    std::uint64_t count = 1;
    if (property.is_list) {
      const double length = next(element, row, property, property.count_kind, property.count_size);
      // Memory for a list is reserved only after checking its length against the file's size.
      if (!(length >= 0.0 && length <= static_cast<double>(room_for(property.size)) && length == std::floor(length))) {
        reject(place(element, row) + ": expected a list '" + property.name +
               "' that fits into the file, found one of " + shortest(length) + " values");
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
    reject((is_text_ ? "expected a number, found none for '" : "truncated: it ends before '") + property.name +
           "' of " + place(element, row));
  }

  [[noreturn]] void reject(const std::string& reason) const {
    if (is_text_) reject_file(file_, words_.line(), reason);
    reject_file(file_, reason);
  }

  /// Largest number of values of this size in the rest of the file: in a text, each needs a digit and a blank.
  std::uint64_t room_for(int value_bytes) const {
    return is_text_ ? (words_.left() + 1) / 2 : static_cast<std::uint64_t>((end_ - at_) / value_bytes);
  }

  const fs::path& file_;
  bool is_text_, swap_;
  const char* at_;
  const char* end_;
  Words words_;
};

/// Axis of each property of a vertex, -1 for none.
std::vector<int> axes_of(const fs::path& file, const PlyHeader::Element& vertex) {
  std::vector<int> axes;
  bool is_there[3] = {};
  for (const PlyHeader::Property& property : vertex.properties) {
    const int axis = property.is_list ? -1 : axis_named(property.name);
    axes.push_back(axis);
    if (axis >= 0) is_there[axis] = true;
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!is_there[axis]) reject_file(file, std::string("expected vertices with x, y and z, found no ") + "xyz"[axis]);
  }
  return axes;
}

bool lists_corners(const PlyHeader::Property& property) {
  return property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
}

std::uint32_t vertex_of(double corner) {
  const bool is_index = corner >= 0.0 && corner < MeshFile::kNoVertex && corner == std::floor(corner);
  return is_index ? static_cast<std::uint32_t>(corner) : MeshFile::kNoVertex;
}

const PlyHeader::Element* find_element(const PlyHeader& header, std::string_view name) {
  const auto found = std::find_if(header.elements.begin(), header.elements.end(),
                                  [&](const auto& element) { return element.name == name; });
  return found == header.elements.end() ? nullptr : &*found;
}

/// Reads the elements in the order of the file, up to `last`. Elements and properties not needed for a mesh are
/// skipped.
MeshFile read_elements(const fs::path& file, std::string_view content, const PlyHeader& header,
                       const PlyHeader::Element& vertex, const PlyHeader::Element* face,
                       const PlyHeader::Element& last) {
  MeshFile mesh;
  const std::vector<int> axes = axes_of(file, vertex);
  mesh.vertices_mesh.reserve(vertex.count);
  PlyValues data(file, header, content);
  std::vector<double> values;
  for (const PlyHeader::Element* element = header.elements.data(); element <= &last; ++element) {
    if (element->properties.empty()) continue;
    for (std::uint64_t row = 0; row < element->count; ++row) {
      if (element == &vertex) mesh.vertices_mesh.emplace_back(Eigen::Vector3d::Zero());
      for (std::size_t i = 0; i < element->properties.size(); ++i) {
        data.take(*element, row, element->properties[i], values);
        if (element == &vertex && axes[i] >= 0) mesh.vertices_mesh.back()[axes[i]] = values[0];
        if (element != face || !lists_corners(element->properties[i])) continue;
        std::transform(values.begin(), values.end(), std::back_inserter(mesh.corners), vertex_of);
      }
      if (element == face) mesh.end_face();
    }
  }
  return mesh;
}

}  // namespace

std::uint64_t PlyHeader::Element::min_bytes() const {
  std::uint64_t bytes = 0;
  for (const Property& property : properties) bytes += property.is_list ? property.count_size : property.size;
  return bytes;
}

PlyHeader parse_ply_header(const fs::path& file, std::string_view content) {
  PlyHeader header = HeaderReader(file, content).read();
  check_length(file, header, content.size());
  return header;
}

MeshFile read_ply_mesh(const fs::path& file, std::string_view content) {
  const PlyHeader header = parse_ply_header(file, content);
  const PlyHeader::Element* const vertex = find_element(header, "vertex");
  const PlyHeader::Element* const face = find_element(header, "face");
  for (const auto& [element, name] : {std::pair(vertex, "vertex"), std::pair(face, "face")}) {
    if (element != nullptr && element->count > 0) continue;
    reject_file(file, std::string("expected a mesh with elements '") + name +
                          "', found none (a point cloud is a world of type cloud)");
  }
  if (std::none_of(face->properties.begin(), face->properties.end(), lists_corners))
    reject_file(file, "expected faces with a list 'vertex_indices', found none");
  MeshFile mesh = read_elements(file, content, header, *vertex, face, header.elements.back());
  mesh.parts.emplace_back();
  return mesh;
}

std::vector<Eigen::Vector3d> read_ply_points(const fs::path& file, std::string_view content) {
  const PlyHeader header = parse_ply_header(file, content);
  const PlyHeader::Element* const vertex = find_element(header, "vertex");
  if (vertex == nullptr) reject_file(file, "expected an element 'vertex', found none");
  return read_elements(file, content, header, *vertex, nullptr, *vertex).vertices_mesh;
}

}  // namespace swiftlet::sim
