// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sim/replay/block.hpp"

namespace swiftlet::sim {

/// A block as the page reads it, written anew here.
struct ReadTable {
  nlohmann::json about;
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;

  std::size_t rows() const { return columns.empty() ? 0 : columns.front().size(); }
  const std::vector<double>& operator[](const std::string& name) const {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == name) return columns[i];
    }
    throw std::out_of_range(name);
  }
};

struct ReadBlock {
  nlohmann::json about;
  std::vector<ReadTable> tables;
};

inline ReadBlock read_block(std::string_view bytes) {
  std::size_t at = 4, length = 0;
  for (int i = 0; i < 4; ++i) length |= static_cast<std::size_t>(static_cast<unsigned char>(bytes[i])) << 8 * i;
  const auto head = nlohmann::json::parse(bytes.substr(4, length));
  at += length;
  ReadBlock block{head["about"], {}};
  for (const auto& table : head["tables"]) {
    ReadTable& read = block.tables.emplace_back();
    read.about = table["about"];
    for (const auto& column : table["columns"]) {
      read.names.push_back(column[0]);
      std::vector<double>& values = read.columns.emplace_back();
      std::int64_t value = 0;
      for (std::size_t row = 0; row < table["rows"].get<std::size_t>(); ++row) {
        std::uint64_t digits = 0;
        int shift = 0;
        for (bool more = true; more; shift += 7) {
          const auto byte = static_cast<unsigned char>(bytes.at(at++));
          digits |= static_cast<std::uint64_t>(byte & 127U) << shift;
          more = byte >= 128;
        }
        value += static_cast<std::int64_t>(digits >> 1) ^ -static_cast<std::int64_t>(digits & 1);
        values.push_back(value == ReplayTable::kMissing ? std::numeric_limits<double>::quiet_NaN()
                                                        : static_cast<double>(value) * column[1].get<double>());
      }
    }
  }
  if (at != bytes.size()) throw std::runtime_error("bytes are left over");
  return block;
}

inline std::string gunzip(std::string_view packed) {
  z_stream stream{};
  inflateInit2(&stream, 15 + 16);
  std::string bytes(1 << 24, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  const int status = inflate(&stream, Z_FINISH);
  bytes.resize(stream.total_out);
  inflateEnd(&stream);
  if (status != Z_STREAM_END) throw std::runtime_error("no gzip");
  return bytes;
}

inline std::string from_base64(std::string_view text) {
  const std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t value = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    value = value << 6 | static_cast<std::uint32_t>(digits.find(c));
    bits += 6;
    if (bits >= 8) bytes.push_back(static_cast<char>(value >> (bits -= 8) & 255U));
  }
  return bytes;
}

/// All blocks of a page, in order.
inline std::vector<ReadBlock> read_page(std::string_view page) {
  const std::string_view begin = "class=\"block\">";
  std::vector<ReadBlock> blocks;
  for (std::size_t at = page.find(begin); at != std::string_view::npos; at = page.find(begin, at)) {
    at += begin.size();
    blocks.push_back(read_block(gunzip(from_base64(page.substr(at, page.find('<', at) - at)))));
  }
  return blocks;
}

}  // namespace swiftlet::sim
