// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/sim/io/byte_buffer.hpp"

namespace swiftlet::sim {

/// Makes 16-bit gray PNG files in memory, several times as fast as a general compressor and no larger. Measured ranges
/// are noise in their low bits. There is nothing to be found there but the statistics of the bytes and runs of equal
/// ones. (PNG, ISO/IEC 15948: filter Sub; RFC 1951: one dynamic Huffman block a file.) Keeps its memory between images.
class GrayPng {
 public:
  /// @param gray  row by row, row 0 on top
  /// @return the file; valid until the next call
  const ByteBuffer& encode(int width, int height, std::span<const std::uint16_t> gray);

 private:
  std::vector<std::uint8_t> filtered_;
  std::vector<std::uint16_t> tokens_;
  std::vector<std::uint8_t> stream_;  // room; what is used of it is written out
  ByteBuffer file_;
};

}  // namespace swiftlet::sim
