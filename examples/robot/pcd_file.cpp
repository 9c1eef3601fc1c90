// SPDX-License-Identifier: BSD-3-Clause
#include "pcd_file.hpp"

#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace {

constexpr std::size_t kMaxCount = 1'000'000'000;  // largest number in a header; larger ones are taken for damage

struct Field {
  std::string name;
  char type = 'F';  // I, U or F
  std::size_t bytes = 0, count = 1;
};

struct Header {
  std::vector<Field> fields;
  std::size_t num_points = 0;
  std::string data;  // ascii, binary or binary_compressed

  std::size_t point_bytes() const {
    std::size_t sum = 0;
    for (const Field& field : fields) sum += field.bytes * field.count;
    return sum;
  }
};

std::size_t whole_number(const std::string& word) {
  std::size_t number = 0;
  const char* const end = word.data() + word.size();
  const auto [at, problem] = std::from_chars(word.data(), end, number);
  if (problem != std::errc() || at != end || number > kMaxCount)
    throw std::runtime_error("expected a whole number in the header, found " + word);
  return number;
}

using Lines = std::map<std::string, std::vector<std::string>>;

std::vector<Field> read_fields(Lines& lines) {
  const std::vector<std::string>& names = lines["FIELDS"];
  if (!lines.contains("COUNT")) lines["COUNT"].assign(names.size(), "1");
  for (const char* key : {"SIZE", "TYPE", "COUNT"}) {
    if (lines[key].size() != names.size())
      throw std::runtime_error("expected " + std::to_string(names.size()) + " values of " + key + ", one for each of " +
                               "FIELDS, found " + std::to_string(lines[key].size()));
  }
  std::vector<Field> fields;
  for (std::size_t i = 0; i < names.size(); ++i) {
    fields.push_back({names[i], lines["TYPE"][i][0], whole_number(lines["SIZE"][i]), whole_number(lines["COUNT"][i])});
    const Field& field = fields.back();
    const bool is_float = field.type == 'F' && (field.bytes == 4 || field.bytes == 8);
    const bool is_whole = (field.type == 'I' || field.type == 'U') &&
                          (field.bytes == 1 || field.bytes == 2 || field.bytes == 4 || field.bytes == 8);
    if (!is_float && !is_whole)
      throw std::runtime_error("field " + field.name +
                               ": expected TYPE I or U with SIZE 1, 2, 4 or 8, or F with 4 or " + "8, found " +
                               lines["TYPE"][i] + " with " + lines["SIZE"][i]);
  }
  return fields;
}

Header read_header(std::istream& in) {
  Lines lines;  // the words after the first of each line
  while (!lines.contains("DATA")) {
    std::string line, key;
    if (!std::getline(in, line)) throw std::runtime_error("expected a PCD file with a line DATA");
    std::istringstream words(line);
    words >> key;
    lines[key].assign(std::istream_iterator<std::string>(words), {});
  }
  if (lines["POINTS"].size() != 1 || lines["DATA"].size() != 1)
    throw std::runtime_error("expected one word after POINTS and one after DATA");
  return {read_fields(lines), whole_number(lines["POINTS"][0]), lines["DATA"][0]};
}

template <class Number>
double number_at(const char* bytes) {
  Number number;
  std::memcpy(&number, bytes, sizeof(number));
  return static_cast<double>(number);
}

double decode(const Field& field, const char* at) {
  if (field.type == 'F') return field.bytes == 4 ? number_at<float>(at) : number_at<double>(at);
  const bool has_sign = field.type == 'I';
  switch (field.bytes) {
    case 1:
      return has_sign ? number_at<std::int8_t>(at) : number_at<std::uint8_t>(at);
    case 2:
      return has_sign ? number_at<std::int16_t>(at) : number_at<std::uint16_t>(at);
    case 4:
      return has_sign ? number_at<std::int32_t>(at) : number_at<std::uint32_t>(at);
    default:
      return has_sign ? number_at<std::int64_t>(at) : number_at<std::uint64_t>(at);
  }
}

std::string read_bytes(std::istream& in, std::size_t size) {
  std::string bytes(size, '\0');
  if (!in.read(bytes.data(), static_cast<std::streamsize>(size)))
    throw std::runtime_error("expected " + std::to_string(size) + " bytes of data, found " +
                             std::to_string(in.gcount()) + ": the file is truncated");
  return bytes;
}

/// Decompresses LZF: a control byte below 32 begins a run of literal bytes, any other one a copy of earlier output.
std::string decompress_lzf(std::string_view in, std::size_t size) {
  std::string out;
  const auto next = [&in] {
    if (in.empty()) throw std::runtime_error("the compressed data are damaged");
    const auto byte = static_cast<unsigned char>(in.front());
    in.remove_prefix(1);
    return static_cast<std::size_t>(byte);
  };
  while (!in.empty()) {
    const std::size_t control = next();
    if (control < 32) {
      for (std::size_t i = 0; i <= control; ++i) out.push_back(static_cast<char>(next()));
    } else {
      std::size_t length = (control >> 5) + 2;
      if (length == 9) length += next();
      const std::size_t distance = ((control & 31) << 8) + next() + 1;
      if (distance > out.size()) throw std::runtime_error("the compressed data are damaged");
      for (std::size_t i = 0; i < length; ++i) out.push_back(out[out.size() - distance]);
    }
    if (out.size() > size) break;
  }
  if (out.size() != size)
    throw std::runtime_error("expected " + std::to_string(size) + " bytes in the compressed data, found " +
                             std::to_string(out.size()));
  return out;
}

/// Reads the columns of binary data. Compressed data are stored field by field, others point by point.
void take_binary(const Header& header, const std::string& bytes, bool by_field, PcdPoints& points) {
  const std::size_t point_bytes = header.point_bytes();
  std::size_t offset = 0;  // place of the field's first value
  for (const Field& field : header.fields) {
    const std::size_t width = field.bytes * field.count;
    if (field.count > 0 && field.name != "_") {
      std::vector<double>& values = points.columns[field.name].values;
      for (std::size_t i = 0; i < header.num_points; ++i)
        values.push_back(decode(field, &bytes[offset + i * (by_field ? width : point_bytes)]));
    }
    offset += width * (by_field ? header.num_points : 1);
  }
}

void take_text(const Header& header, std::istream& in, PcdPoints& points) {
  std::string word;  // std::istream reads no "nan"
  for (std::size_t i = 0; i < header.num_points; ++i) {
    for (const Field& field : header.fields) {
      for (std::size_t k = 0; k < field.count; ++k) {
        char* end = nullptr;
        const double value = in >> word ? std::strtod(word.c_str(), &end) : 0.0;
        if (end == nullptr || end == word.c_str() || *end != '\0')
          throw std::runtime_error("point " + std::to_string(i) + ": expected a number for " + field.name +
                                   ", found \"" + word + "\"");
        if (k == 0 && field.name != "_") points.columns[field.name].values.push_back(value);
      }
    }
  }
}

}  // namespace

PcdPoints read_pcd(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error("expected a PCD file, found none");
  const Header header = read_header(in);
  PcdPoints points;
  for (const Field& field : header.fields) {
    if (field.count > 0 && field.name != "_") points.columns[field.name].is_whole_number = field.type != 'F';
  }
  const std::size_t size = header.point_bytes() * header.num_points;
  if (header.data == "ascii") {
    take_text(header, in, points);
  } else if (header.data == "binary") {
    take_binary(header, read_bytes(in, size), false, points);
  } else if (header.data == "binary_compressed") {
    const std::string sizes = read_bytes(in, 8);
    const auto compressed = static_cast<std::size_t>(number_at<std::uint32_t>(sizes.data()));
    take_binary(header, decompress_lzf(read_bytes(in, compressed), size), true, points);
  } else {
    throw std::runtime_error("expected DATA ascii, binary or binary_compressed, found " + header.data);
  }
  return points;
}
