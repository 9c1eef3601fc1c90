// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/point_cloud_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <sstream>

#include "sim/world/input_file.hpp"
#include "sim/world/number_reading.hpp"
#include "sim/world/ply_file.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

void keep_finite(std::vector<Vector3d>& points, const Vector3d& point) {
  if (point.allFinite()) points.push_back(point);
}

// A column of a table of points: where x, y or z lies.
struct Column {
  std::size_t offset = 0;  // bytes from the start of a point, or words in a text file
  char kind = 'f';
  int size = 4;
};

std::vector<Vector3d> read_ply(const fs::path& file, const std::string& content) {
  const PlyHeader header = parse_ply_header(file, content);
  const PlyHeader::Element* vertex = nullptr;
  std::size_t begin = header.data_begin;
  std::uint64_t skipped_words = 0;
  for (const PlyHeader::Element& element : header.elements) {
    if (element.name == "vertex") {
      vertex = &element;
      break;
    }
    if (element.has_list()) reject_file(file, "expected the vertices before element '" + element.name + "'");
    begin += element.min_bytes() * element.count;
    skipped_words += element.properties.size() * element.count;
  }
  if (vertex == nullptr) reject_file(file, "expected an element 'vertex', found none");
  if (vertex->has_list()) reject_file(file, "expected vertices without lists");

  const bool is_text = header.format == PlyHeader::Format::kAscii;
  std::array<std::optional<Column>, 3> columns;
  std::size_t stride = 0;
  for (const PlyHeader::Property& property : vertex->properties) {
    for (int axis = 0; axis < 3; ++axis) {
      if (property.name == std::string(1, "xyz"[axis])) columns[axis] = {stride, property.kind, property.size};
    }
    stride += is_text ? 1 : property.size;
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!columns[axis]) reject_file(file, std::string("expected vertices with x, y and z, found no ") + "xyz"[axis]);
  }

  std::vector<Vector3d> points;
  points.reserve(vertex->count);
  if (is_text) {
    Words words(content, header.data_begin);
    for (std::uint64_t i = 0; i < skipped_words; ++i) words.number();
    for (std::uint64_t i = 0; i < vertex->count; ++i) {
      Vector3d point;
      for (std::size_t word = 0; word < stride; ++word) {
        const auto value = words.number();
        if (!value)
          reject_file(file, "vertex " + std::to_string(i) + ": expected " + std::to_string(stride) + " numbers");
        for (int axis = 0; axis < 3; ++axis) {
          if (columns[axis]->offset == word) point[axis] = *value;
        }
      }
      keep_finite(points, point);
    }
    return points;
  }
  if (begin > content.size() || content.size() - begin < stride * vertex->count)
    reject_file(file, "truncated: the vertices are not complete");
  const bool swap = (header.format == PlyHeader::Format::kBigEndian) != (std::endian::native == std::endian::big);
  for (std::uint64_t i = 0; i < vertex->count; ++i) {
    const char* row = content.data() + begin + i * stride;
    Vector3d point;
    for (int axis = 0; axis < 3; ++axis)
      point[axis] = decode(row + columns[axis]->offset, columns[axis]->kind, columns[axis]->size, swap);
    keep_finite(points, point);
  }
  return points;
}

struct PcdHeader {
  struct Field {
    std::string name;
    int size = 4;
    char kind = 'f';
    std::uint64_t count = 1;
  };
  std::vector<Field> fields;
  std::uint64_t points = 0;
  std::string data;
  std::size_t data_begin = 0;

  std::uint64_t stride() const {
    std::uint64_t bytes = 0;
    for (const Field& field : fields) bytes += field.size * field.count;
    return bytes;
  }
};

template <class Value, class Store>
void read_list(const fs::path& file, std::istringstream& words, const std::string& line, PcdHeader& header,
               const Store& store) {
  for (PcdHeader::Field& field : header.fields) {
    Value value{};
    if (!(words >> value) || !store(field, value)) {
      reject_file(file, "PCD header: expected a valid entry for each of " + std::to_string(header.fields.size()) +
                            " fields, found '" + line + "'");
    }
  }
}

PcdHeader parse_pcd_header(const fs::path& file, const std::string& content) {
  constexpr std::size_t kMaxHeaderBytes = 1 << 20;
  PcdHeader header;
  std::optional<std::uint64_t> width, height, points;
  std::size_t position = 0;
  while (header.data.empty()) {
    const std::size_t end = content.find('\n', position);
    if (end == std::string::npos || end > kMaxHeaderBytes)
      reject_file(file, "expected a PCD header that ends with 'DATA', found none");
    std::string line = content.substr(position, end - position);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    position = end + 1;
    std::istringstream words(line);
    std::string word;
    words >> word;
    const auto number = [&](std::optional<std::uint64_t>& value) {
      std::uint64_t n = 0;
      if (!(words >> n) || line.find('-') != std::string::npos)
        reject_file(file, "PCD header: expected a number, found '" + line + "'");
      value = n;
    };
    if (word == "FIELDS" || word == "COLUMNS") {
      for (std::string name; words >> name;) header.fields.push_back({name});
    } else if (word == "SIZE") {
      read_list<int>(file, words, line, header, [](PcdHeader::Field& field, int size) {
        field.size = size;
        return size == 1 || size == 2 || size == 4 || size == 8;
      });
    } else if (word == "TYPE") {
      read_list<char>(file, words, line, header, [](PcdHeader::Field& field, char kind) {
        field.kind = static_cast<char>(std::tolower(static_cast<unsigned char>(kind)));
        return field.kind == 'f' || field.kind == 'i' || field.kind == 'u';
      });
    } else if (word == "COUNT") {
      read_list<int>(file, words, line, header, [](PcdHeader::Field& field, int count) {
        field.count = static_cast<std::uint64_t>(count);
        return count >= 0 && count < 100000;
      });
    } else if (word == "WIDTH") {
      number(width);
    } else if (word == "HEIGHT") {
      number(height);
    } else if (word == "POINTS") {
      number(points);
    } else if (word == "DATA") {
      if (!(words >> header.data)) reject_file(file, "PCD header: expected a kind of data, found '" + line + "'");
    } else if (!word.empty() && word[0] != '#' && word != "VERSION" && word != "VIEWPOINT") {
      reject_file(file, "expected a PCD header, found '" + line.substr(0, 60) + "'");
    }
  }
  for (const PcdHeader::Field& field : header.fields) {
    if (field.kind == 'f' && field.size < 4)
      reject_file(file, "PCD header: expected a size of 4 or 8 for type F of field '" + field.name + "'");
  }
  if (points)
    header.points = *points;
  else if (width && height && (*height == 0 || *width <= (1ULL << 40) / *height))
    header.points = *width * *height;
  else
    reject_file(file, "PCD header: expected POINTS, or WIDTH and HEIGHT");
  header.data_begin = position;
  return header;
}

std::vector<Vector3d> read_pcd_text(const fs::path& file, const std::string& content, const PcdHeader& header,
                                    const std::array<std::size_t, 3>& fields) {
  std::vector<Vector3d> points;
  if (header.points > content.size())
    reject_file(file, "truncated: the PCD header promises " + std::to_string(header.points) + " points");
  points.reserve(header.points);
  Words words(content, header.data_begin);
  for (std::uint64_t i = 0; i < header.points; ++i) {
    Vector3d point;
    for (std::size_t field = 0; field < header.fields.size(); ++field) {
      for (std::uint64_t k = 0; k < header.fields[field].count; ++k) {
        const auto value = words.number();
        if (!value)
          reject_file(
              file, "point " + std::to_string(i) + ": expected a number for field '" + header.fields[field].name + "'");
        for (int axis = 0; axis < 3; ++axis) {
          if (fields[axis] == field && k == 0) point[axis] = *value;
        }
      }
    }
    keep_finite(points, point);
  }
  return points;
}

// Uncompressed data: point by point. Compressed data: field by field.
std::vector<Vector3d> read_pcd_binary(const fs::path& file, std::string_view data, const PcdHeader& header,
                                      const std::array<std::size_t, 3>& fields, bool by_field) {
  const std::uint64_t stride = header.stride();
  if (stride == 0 || header.points > data.size() / stride) {
    reject_file(file, "truncated: expected " + std::to_string(header.points) + " points of " + std::to_string(stride) +
                          " bytes, found " + std::to_string(data.size()) + " bytes");
  }
  std::vector<std::uint64_t> offsets;
  std::uint64_t offset = 0;
  for (const PcdHeader::Field& field : header.fields) {
    offsets.push_back(offset);
    offset += field.size * field.count * (by_field ? header.points : 1);
  }
  constexpr bool kSwap = std::endian::native == std::endian::big;
  std::vector<Vector3d> points;
  points.reserve(header.points);
  for (std::uint64_t i = 0; i < header.points; ++i) {
    Vector3d point;
    for (int axis = 0; axis < 3; ++axis) {
      const PcdHeader::Field& field = header.fields[fields[axis]];
      const std::uint64_t step = by_field ? field.size * field.count : stride;
      point[axis] = decode(data.data() + offsets[fields[axis]] + i * step, field.kind, field.size, kSwap);
    }
    keep_finite(points, point);
  }
  return points;
}

std::vector<Vector3d> read_pcd(const fs::path& file, const std::string& content) {
  const PcdHeader header = parse_pcd_header(file, content);
  std::array<std::size_t, 3> fields{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto match = [&](const PcdHeader::Field& field) {
      return field.name == std::string(1, "xyz"[axis]) && field.count > 0;
    };
    const auto found = std::find_if(header.fields.begin(), header.fields.end(), match);
    if (found == header.fields.end())
      reject_file(file, std::string("expected points with x, y and z, found no ") + "xyz"[axis]);
    fields[axis] = static_cast<std::size_t>(found - header.fields.begin());
  }
  const std::string_view data = std::string_view(content).substr(header.data_begin);
  if (header.data == "ascii") return read_pcd_text(file, content, header, fields);
  if (header.data == "binary") return read_pcd_binary(file, data, header, fields, false);
  if (header.data != "binary_compressed") {
    reject_file(file, "expected DATA ascii, binary or binary_compressed, found '" + header.data + "'");
  }
  if (data.size() < 8) reject_file(file, "truncated: expected the sizes of the compressed data");
  const auto compressed =
      static_cast<std::uint64_t>(decode(data.data(), 'u', 4, std::endian::native == std::endian::big));
  const auto uncompressed =
      static_cast<std::uint64_t>(decode(data.data() + 4, 'u', 4, std::endian::native == std::endian::big));
  if (data.size() - 8 < compressed) {
    reject_file(file, "truncated: expected " + std::to_string(compressed) + " compressed bytes, found " +
                          std::to_string(data.size() - 8));
  }
  // Three bytes stand for 264 at most.
  if (uncompressed > 88 * (compressed + 1))
    reject_file(file, "damaged: the compressed data cannot hold " + std::to_string(uncompressed) + " bytes");
  std::string plain(uncompressed, '\0');
  if (!decompress_lzf(data.substr(8, compressed), plain))
    reject_file(file, "damaged: the compressed data do not decompress");
  return read_pcd_binary(file, plain, header, fields, true);
}

}  // namespace

bool decompress_lzf(std::string_view in, std::string& out) {
  std::size_t from = 0;
  std::size_t to = 0;
  const auto byte = [&](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(in[i])); };
  while (from < in.size()) {
    const std::size_t control = byte(from++);
    if (control < 32) {  // a run of literal bytes
      const std::size_t length = control + 1;
      if (in.size() - from < length || out.size() - to < length) return false;
      std::copy_n(in.data() + from, length, out.data() + to);
      from += length;
      to += length;
      continue;
    }
    // A copy of earlier output, which may overlap what it writes.
    std::size_t length = control >> 5;
    if (length == 7) {
      if (from == in.size()) return false;
      length += byte(from++);
    }
    length += 2;
    if (from == in.size()) return false;
    const std::size_t distance = ((control & 31) << 8) + byte(from++) + 1;
    if (distance > to || out.size() - to < length) return false;
    for (std::size_t i = 0; i < length; ++i, ++to) out[to] = out[to - distance];
  }
  return to == out.size();
}

std::vector<Vector3d> read_point_cloud(const fs::path& file) {
  const std::string extension = extension_of(file);
  if (extension != "pcd" && extension != "ply") reject_file(file, "expected a point cloud named .pcd or .ply");
  const std::string content = read_whole_file(file);
  return extension == "pcd" ? read_pcd(file, content) : read_ply(file, content);
}

}  // namespace swiftlet::sim
