// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/number_reading.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace swiftlet::sim {

double decode(const char* bytes, char kind, int size, bool swap) {
  std::array<char, 8> word{};
  std::copy_n(bytes, size, word.begin());
  if (swap) std::reverse(word.begin(), word.begin() + size);
  const auto as = [&]<class Value>(Value value) {
    std::memcpy(&value, word.data(), sizeof value);
    return static_cast<double>(value);
  };
  if (kind == 'f') return size == 4 ? as(float{}) : as(double{});
  if (kind == 'i')
    return size == 1   ? as(std::int8_t{})
           : size == 2 ? as(std::int16_t{})
           : size == 4 ? as(std::int32_t{})
                       : as(std::int64_t{});
  return size == 1   ? as(std::uint8_t{})
         : size == 2 ? as(std::uint16_t{})
         : size == 4 ? as(std::uint32_t{})
                     : as(std::uint64_t{});
}

double number_or_nan(std::string_view word) { return Words(word, 0).number().value_or(std::nan("")); }

std::size_t Words::line() const { return 1 + static_cast<std::size_t>(std::count(content_, next_, '\n')); }

std::optional<double> Words::number() {
  while (next_ != end_ && std::isspace(static_cast<unsigned char>(*next_))) ++next_;
  if (next_ != end_ && *next_ == '+') ++next_;
  double value = 0.0;
  const auto result = std::from_chars(next_, end_, value);
  if (result.ec == std::errc::result_out_of_range)
    value = std::nan("");
  else if (result.ec != std::errc())
    return std::nullopt;
  next_ = result.ptr;
  if (next_ != end_ && !std::isspace(static_cast<unsigned char>(*next_))) return std::nullopt;
  return value;
}

}  // namespace swiftlet::sim
