// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/io/base64.hpp"

#include <cstdint>

namespace swiftlet::sim {

std::string base64(std::string_view bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t triple = 0;
    for (std::size_t k = i; k < i + 3; ++k)
      triple = triple << 8 | (k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text.push_back(i + k <= bytes.size() ? kDigits[(triple >> (18 - 6 * k)) & 63U] : '=');
  }
  return text;
}

}  // namespace swiftlet::sim
