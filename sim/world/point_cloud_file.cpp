// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/point_cloud_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>

#include "sim/world/input_file.hpp"
#include "sim/world/number_reading.hpp"
#include "sim/world/ply_file.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

void keep_finite(std::vector<Vector3d>& points, const Vector3d& point) {
  if (point.allFinite()) points.push_back(point);
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

/// Parser of the header of a PCD file, line by line.
class PcdHeaderReader {
 public:
  PcdHeaderReader(const fs::path& file, std::string_view content) : file_(file), lines_(content) {}

  PcdHeader read() {
    // Longest accepted header.
    constexpr std::size_t kMaxHeaderBytes = 1 << 20;
    while (header_.data.empty()) {
      if (!lines_.next() || lines_.end() > kMaxHeaderBytes)
        reject_file(file_, "expected a PCD header that ends with 'DATA', found none");
      split(lines_.line(), words_);
      if (!words_.empty() && !words_[0].starts_with('#')) take_line();
    }
    for (const PcdHeader::Field& field : header_.fields) {
      if (field.kind == 'f' && field.size < 4)
        reject_file(file_, "PCD header: expected a size of 4 or 8 for type F of field '" + field.name + "'");
    }
    header_.points = num_points();
    header_.data_begin = lines_.end();
    return std::move(header_);
  }

 private:
  [[noreturn]] void reject(const std::string& expected) const {
    reject_file(file_, lines_.number(),
                "PCD header: expected " + expected + ", found '" + std::string(lines_.line().substr(0, 60)) + "'");
  }

  void take_line() {
    const std::string_view word = words_[0];
    if (word == "FIELDS" || word == "COLUMNS") {
      header_.fields.clear();
      for (std::size_t i = 1; i < words_.size(); ++i) header_.fields.push_back({std::string(words_[i])});
    } else if (word == "SIZE") {
      for_each_field([](PcdHeader::Field& field, std::string_view entry) {
        field.size = number_in<int>(entry).value_or(0);
        return field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8;
      });
    } else if (word == "TYPE") {
      for_each_field([](PcdHeader::Field& field, std::string_view entry) {
        field.kind = lower_case(entry)[0];
        return entry.size() == 1 && (field.kind == 'f' || field.kind == 'i' || field.kind == 'u');
      });
    } else if (word == "COUNT") {
      for_each_field([](PcdHeader::Field& field, std::string_view entry) {
        const auto count = number_in<std::uint32_t>(entry);
        field.count = count.value_or(0);
        return count && *count < 100000;
      });
    } else if (word == "WIDTH" || word == "HEIGHT" || word == "POINTS") {
      const auto number = words_.size() == 2 ? number_in<std::uint64_t>(words_[1]) : std::nullopt;
      if (!number) reject("a whole number");
      (word == "WIDTH" ? width_ : word == "HEIGHT" ? height_ : points_) = number;
    } else if (word == "DATA") {
      if (words_.size() != 2) reject("a kind of data");
      header_.data = words_[1];
    } else if (word != "VERSION" && word != "VIEWPOINT") {
      reject_file(file_, lines_.number(),
                  "expected a PCD header, found '" + std::string(lines_.line().substr(0, 60)) + "'");
    }
  }

  /// Passes its entry of the line to each field; `store` returns whether it is valid.
  template <class Store>
  void for_each_field(const Store& store) {
    bool is_valid = words_.size() == header_.fields.size() + 1;
    for (std::size_t i = 0; is_valid && i < header_.fields.size(); ++i)
      is_valid = store(header_.fields[i], words_[i + 1]);
    if (!is_valid) reject("a valid entry for each of " + std::to_string(header_.fields.size()) + " fields");
  }

  std::uint64_t num_points() const {
    std::optional<std::uint64_t> product;
    if (width_ && height_ && (*height_ == 0 || *width_ <= (1ULL << 40) / *height_)) product = *width_ * *height_;
    if (!points_ && !product) reject_file(file_, "PCD header: expected POINTS, or WIDTH and HEIGHT");
    if (points_ && product && *points_ != *product) {
      reject_file(file_, "PCD header: expected WIDTH x HEIGHT = POINTS, found " + std::to_string(*product) + " and " +
                             std::to_string(*points_));
    }
    return points_ ? *points_ : *product;
  }

  const fs::path& file_;
  TextLines lines_;
  std::vector<std::string_view> words_;
  PcdHeader header_;
  std::optional<std::uint64_t> width_, height_, points_;
};

std::vector<Vector3d> read_pcd_text(const fs::path& file, std::string_view content, const PcdHeader& header,
                                    const std::array<std::size_t, 3>& fields) {
  std::vector<Vector3d> points;
  if (header.points > content.size())
    reject_file(file, "truncated: the PCD header announces " + std::to_string(header.points) + " points");
  points.reserve(header.points);
  Words words(content, header.data_begin);
  for (std::uint64_t i = 0; i < header.points; ++i) {
    Vector3d point;
    for (std::size_t field = 0; field < header.fields.size(); ++field) {
      for (std::uint64_t k = 0; k < header.fields[field].count; ++k) {
        const auto value = words.number();
        if (!value) {
          reject_file(
              file, words.line(),
              "point " + std::to_string(i) + ": expected a number for field '" + header.fields[field].name + "'");
        }
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

std::vector<Vector3d> read_pcd(const fs::path& file, std::string_view content) {
  const PcdHeader header = PcdHeaderReader(file, content).read();
  std::array<std::size_t, 3> fields{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto match = [&](const PcdHeader::Field& field) { return axis_named(field.name) == axis && field.count > 0; };
    const auto found = std::find_if(header.fields.begin(), header.fields.end(), match);
    if (found == header.fields.end())
      reject_file(file, std::string("expected points with x, y and z, found no ") + "xyz"[axis]);
    fields[axis] = static_cast<std::size_t>(found - header.fields.begin());
  }
  const std::string_view data = content.substr(header.data_begin);
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
  // Three compressed bytes expand to at most 264.
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
    // A copy of earlier output, which may overlap the destination.
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
  const std::string_view text = without_mark(content);
  if (extension == "pcd") return read_pcd(file, text);
  std::vector<Vector3d> points = read_ply_points(file, text);
  std::erase_if(points, [](const Vector3d& point) { return !point.allFinite(); });
  return points;
}

}  // namespace swiftlet::sim
