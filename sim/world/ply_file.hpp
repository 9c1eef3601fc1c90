// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// PLY files (G. Turk, 1994): text and binary of either byte order.
namespace swiftlet::sim {

/// Header of a PLY file.
struct PlyHeader {
  enum class Format { kAscii, kLittleEndian, kBigEndian };
  struct Property {
    std::string name;
    char kind = 'f';  ///< i: signed, u: unsigned, f: floating
    int size = 4;     ///< bytes
    bool is_list = false;
    char count_kind = 'u';  ///< type of a list's length
    int count_size = 0;     ///< bytes of a list's length
  };
  struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
    std::uint64_t min_bytes() const;  ///< size of one element in a binary file; lists counted as empty
  };
  Format format = Format::kAscii;
  std::vector<Element> elements;
  std::size_t data_begin = 0;  ///< offset of the first byte after the header
};

/// Parses the header and checks that the file is long enough for its elements.
PlyHeader parse_ply_header(const std::filesystem::path& file, std::string_view content);

/// The vertices of a cloud. Coordinates may be infinite or NaN.
std::vector<Eigen::Vector3d> read_ply_points(const std::filesystem::path& file, std::string_view content);

}  // namespace swiftlet::sim
