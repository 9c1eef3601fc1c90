// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

/// Reading files that others wrote: everything that can be wrong with them ends in one clear line.
namespace swiftlet::sim {

/// Throws InputError: "<file>: <reason>".
[[noreturn]] void reject_file(const std::filesystem::path& file, const std::string& reason);

/// The extension in lower case without its dot.
std::string extension_of(const std::filesystem::path& file);

/// The head of a PLY file.
struct PlyHeader {
  enum class Format { kAscii, kLittleEndian, kBigEndian };
  struct Property {
    std::string name;
    char kind = 'f';  ///< i: signed, u: unsigned, f: floating
    int size = 4;     ///< bytes
    bool is_list = false;
    int count_size = 0;  ///< bytes of a list's length
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

/// Checks that no list is longer than the rest of the file: a reader would make room for it before it looks.
void check_ply_lists(const std::filesystem::path& file, const PlyHeader& header, const std::string& content);

}  // namespace swiftlet::sim
