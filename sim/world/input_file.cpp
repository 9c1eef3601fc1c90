// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/input_file.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>
#include <sstream>

#include "swiftlet/sim/errors.hpp"

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
  char count_kind = 'u';
  if (type == "list") {
    property.is_list = true;
    std::string count_type;
    words >> count_type >> type;
    if (!parse_type(count_type, count_kind, property.count_size) || count_kind == 'f') {
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

/// Walks over the data of a PLY file; only the lengths of lists are read.
class PlyData {
 public:
  PlyData(const PlyHeader& header, const std::string& content)
      : format_(header.format), at_(content.data() + header.data_begin), end_(content.data() + content.size()) {}

  bool is_over() const { return at_ == end_; }
  bool is_text() const { return format_ == PlyHeader::Format::kAscii; }
  bool has_bytes(int bytes) const { return is_text() || end_ - at_ >= bytes; }
  /// What the rest of the file can hold of values of this size.
  std::uint64_t room_for(int value_bytes) const {
    const auto left = static_cast<std::uint64_t>(end_ - at_);
    return is_text() ? (left + 1) / 2 : left / static_cast<std::uint64_t>(value_bytes);
  }
  void skip(std::uint64_t values, int value_bytes) {
    if (!is_text()) {
      at_ += std::min(static_cast<std::uint64_t>(end_ - at_), values * static_cast<std::uint64_t>(value_bytes));
      return;
    }
    for (std::uint64_t i = 0; i < values && !is_over(); ++i) word();
  }
  /// Negative lengths come out as very long ones.
  std::uint64_t list_length(int count_bytes) {
    std::uint64_t length = 0;
    if (is_text()) {
      const std::string_view text = word();
      const bool is_whole = std::from_chars(text.data(), text.data() + text.size(), length).ec == std::errc();
      return is_whole || text.empty() || text[0] != '-' ? length : ~std::uint64_t{0};
    }
    if (end_ - at_ < count_bytes) {
      at_ = end_;
      return 0;
    }
    char bytes[8] = {};
    std::copy_n(at_, count_bytes, bytes);
    if (format_ == PlyHeader::Format::kBigEndian) std::reverse(bytes, bytes + count_bytes);
    at_ += count_bytes;
    std::memcpy(&length, bytes, sizeof length);
    return length;
  }

 private:
  std::string_view word() {
    const auto is_space = [](unsigned char c) { return std::isspace(c) != 0; };
    const char* const begin = std::find_if_not(at_, end_, is_space);
    at_ = std::find_if(begin, end_, is_space);
    return {begin, at_};
  }

  PlyHeader::Format format_;
  const char* at_;
  const char* end_;
};

}  // namespace

void reject_file(const fs::path& file, const std::string& reason) { throw InputError(file.string() + ": " + reason); }

std::string extension_of(const fs::path& file) {
  std::string extension = file.extension().string();
  if (!extension.empty()) extension.erase(0, 1);
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

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

void check_ply_lists(const fs::path& file, const PlyHeader& header, const std::string& content) {
  PlyData data(header, content);
  for (const PlyHeader::Element& element : header.elements) {
    if (element.properties.empty()) continue;
    for (std::uint64_t i = 0; i < element.count && !(data.is_text() && data.is_over()); ++i) {
      for (const PlyHeader::Property& property : element.properties) {
        // The library reads on behind the end, and takes what lies there for a length.
        if (!data.has_bytes(property.is_list ? property.count_size : property.size))
          reject_file(file,
                      "truncated: it ends before '" + property.name + "' of " + element.name + " " + std::to_string(i));
        const std::uint64_t length = property.is_list ? data.list_length(property.count_size) : 1;
        if (property.is_list && length > data.room_for(property.size)) {
          reject_file(file, element.name + " " + std::to_string(i) + ": expected a list '" + property.name +
                                "' that fits into the file, found one of " + std::to_string(length) + " values");
        }
        data.skip(length, property.size);
      }
    }
  }
}

}  // namespace swiftlet::sim
