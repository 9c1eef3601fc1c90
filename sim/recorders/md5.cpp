// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/md5.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace swiftlet::sim {
namespace {

using Words = std::array<std::uint32_t, 4>;

/// Table of the RFC: the first 32 bits of the fraction of |sin(i)|.
std::array<std::uint32_t, 64> sine_table() {
  std::array<std::uint32_t, 64> table{};
  for (int i = 0; i < 64; ++i)
    table[i] = static_cast<std::uint32_t>(std::floor(std::abs(std::sin(i + 1.0)) * 4294967296.0));
  return table;
}

void add_block(const unsigned char* block, Words& digest) {
  static const std::array<std::uint32_t, 64> kSines = sine_table();
  static constexpr int kTurns[4][4] = {{7, 12, 17, 22}, {5, 9, 14, 20}, {4, 11, 16, 23}, {6, 10, 15, 21}};
  std::uint32_t words[16] = {};
  for (int i = 0; i < 64; ++i) words[i / 4] |= static_cast<std::uint32_t>(block[i]) << (8 * (i % 4));
  auto [a, b, c, d] = digest;
  for (int i = 0; i < 64; ++i) {
    std::uint32_t f = 0;
    int word = 0;
    switch (i / 16) {
      case 0:
        f = (b & c) | (~b & d), word = i;
        break;
      case 1:
        f = (d & b) | (~d & c), word = 5 * i + 1;
        break;
      case 2:
        f = b ^ c ^ d, word = 3 * i + 5;
        break;
      default:
        f = c ^ (b | ~d), word = 7 * i;
        break;
    }
    const std::uint32_t sum = a + f + kSines[i] + words[word % 16];
    a = d;
    d = c;
    c = b;
    b += std::rotl(sum, kTurns[i / 16][i % 4]);
  }
  digest[0] += a;
  digest[1] += b;
  digest[2] += c;
  digest[3] += d;
}

}  // namespace

std::string md5(std::string_view text) {
  std::string padded(text);
  padded.push_back(static_cast<char>(0x80));
  while (padded.size() % 64 != 56) padded.push_back('\0');
  for (int i = 0; i < 8; ++i) padded.push_back(static_cast<char>(8 * std::uint64_t{text.size()} >> (8 * i)));
  Words digest = {0x67452301, 0xefcdab89, 0x98badcfe, 0x10325476};
  for (std::size_t at = 0; at < padded.size(); at += 64) {
    add_block(reinterpret_cast<const unsigned char*>(padded.data()) + at, digest);
  }
  std::string hex;
  for (const std::uint32_t word : digest) {
    for (int i = 0; i < 4; ++i) {
      hex.push_back("0123456789abcdef"[word >> (8 * i + 4) & 15]);
      hex.push_back("0123456789abcdef"[word >> (8 * i) & 15]);
    }
  }
  return hex;
}

}  // namespace swiftlet::sim
