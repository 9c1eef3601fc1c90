// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/sim/io/byte_buffer.hpp"

namespace swiftlet::sim {

/// Encodes 16-bit gray PNG files in memory, several times as fast as a general compressor and no larger. The low bits
/// of measured ranges are noise, so only byte statistics and runs of equal bytes are compressible. (PNG, ISO/IEC 15948:
/// filter Sub; RFC 1951: one dynamic Huffman block per file.) Keeps its memory between images.
class GrayPng {
 public:
  /// @param gray  row by row, row 0 on top
  /// @return the file; valid until the next call
  const ByteBuffer& encode(int width, int height, std::span<const std::uint16_t> gray);

 private:
  std::vector<std::uint8_t> filtered_;
  std::vector<std::uint16_t> tokens_;
  std::vector<std::uint8_t> stream_;  // reserved memory; only its used part is written
  ByteBuffer file_;
};

}  // namespace swiftlet::sim
