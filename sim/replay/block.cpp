// SPDX-License-Identifier: BSD-3-Clause
#include "sim/replay/block.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet::sim {
namespace {

std::int32_t quantized(double value, double step) {
  if (!std::isfinite(value)) return ReplayTable::kMissing;
  constexpr double kMost = -ReplayTable::kMissing - 1;
  return static_cast<std::int32_t>(std::clamp(std::round(value / step), -kMost, kMost));
}

void append_digits(std::string& body, std::uint32_t value) {
  for (; value >= 128; value >>= 7) body.push_back(static_cast<char>((value & 127U) | 128U));
  body.push_back(static_cast<char>(value));
}

void append_column(std::string& body, const std::vector<std::int32_t>& values) {
  std::int32_t last = 0;
  for (const std::int32_t value : values) {
    const std::int32_t difference = value - last;  // values have 30 bits, so no overflow
    append_digits(body, (static_cast<std::uint32_t>(difference) << 1) ^ static_cast<std::uint32_t>(difference >> 31));
    last = value;
  }
}

}  // namespace

ReplayTable::ReplayTable(std::string about, std::vector<ReplayColumn> columns)
    : about_(std::move(about)), columns_(std::move(columns)), values_(columns_.size()) {}

void ReplayTable::add(std::span<const double> row) {
  ENSURE(row.size() == columns_.size(), row.size(), columns_.size());
  for (std::size_t i = 0; i < row.size(); ++i) values_[i].push_back(quantized(row[i], columns_[i].step));
}

void ReplayTable::clear() {
  for (auto& column : values_) column.clear();
}

void ReplayBlock::add(const ReplayTable& table) {
  nlohmann::ordered_json head;
  head["rows"] = table.rows();
  for (const ReplayColumn& column : table.columns()) head["columns"].push_back({column.name, column.step});
  if (!heads_.empty()) heads_ += ',';
  heads_ += fmt::format("{{\"about\":{},{}", table.about(), head.dump().substr(1));
  for (std::size_t i = 0; i < table.columns().size(); ++i) append_column(body_, table.values(i));
}

std::string ReplayBlock::bytes() const {
  const std::string head = fmt::format("{{\"about\":{},\"tables\":[{}]}}", about_, heads_);
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>((head.size() >> shift) & 255U));
  return bytes + head + body_;
}

std::string gzip(std::string_view bytes) {
  z_stream stream{};
  constexpr int kWindow = 15, kAsGzip = 16, kMemory = 9;
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kWindow + kAsGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::string packed(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int status = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  ENSURE(status == Z_STREAM_END, status);
  return packed;
}

}  // namespace swiftlet::sim
