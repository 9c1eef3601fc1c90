// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/gray_png.hpp"

#include <gtest/gtest.h>
#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <queue>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet::sim {
namespace {

/// Pixels as read by libpng.
std::vector<std::uint16_t> read_by_libpng(const ByteBuffer& file, int& width, int& height) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, file.bytes().data(), file.size()), 0) << image.message;
  width = static_cast<int>(image.width);
  height = static_cast<int>(image.height);
  EXPECT_TRUE(image.format & PNG_FORMAT_FLAG_LINEAR);  // 16 bits
  // The simplified reader converts; the bytes as they are come by the classic one.
  png_image_free(&image);
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  struct Source {
    const std::byte* at;
  } source{file.bytes().data()};
  png_set_read_fn(png, &source, [](png_structp p, png_bytep out, png_size_t count) {
    auto* from = static_cast<Source*>(png_get_io_ptr(p));
    std::memcpy(out, from->at, count);
    from->at += count;
  });
  std::vector<std::uint16_t> gray(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::vector<png_bytep> rows;
  for (int y = 0; y < height; ++y)
    rows.push_back(reinterpret_cast<png_bytep>(gray.data() + static_cast<std::size_t>(y) * width));
  png_read_info(png, info);
  EXPECT_EQ(png_get_bit_depth(png, info), 16);
  EXPECT_EQ(png_get_color_type(png, info), PNG_COLOR_TYPE_GRAY);
  png_set_swap(png);
  png_read_image(png, rows.data());
  png_read_end(png, nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
  return gray;
}

std::uint32_t big_endian_at(const ByteBuffer& file, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | std::to_integer<std::uint32_t>(file.bytes()[at + i]);
  return value;
}

/// Filtered rows of the picture before compression; chunks and all checksums are checked against the standards.
std::vector<std::uint8_t> filtered_rows(const ByteBuffer& file, int width, int height) {
  std::vector<std::uint8_t> rows(static_cast<std::size_t>(height) * (2 * static_cast<std::size_t>(width) + 1));
  std::string kinds;
  for (std::size_t at = 8; at + 12 <= file.size();) {
    const std::size_t length = big_endian_at(file, at);
    const auto* const content = reinterpret_cast<const Bytef*>(file.bytes().data()) + at + 4;
    EXPECT_EQ(big_endian_at(file, at + 8 + length), crc32(0, content, static_cast<uInt>(length + 4)));
    const std::string kind(reinterpret_cast<const char*>(content), 4);
    kinds += kind + " ";
    if (kind == "IDAT") {
      uLongf size = rows.size();
      EXPECT_EQ(uncompress(rows.data(), &size, content + 4, length), Z_OK);  // also checks the checksum
      EXPECT_EQ(size, rows.size());
    }
    at += 12 + length;
    if (kind == "IEND") {
      EXPECT_EQ(at, file.size());
    }
  }
  EXPECT_EQ(kinds, "IHDR IDAT IEND ");
  return rows;
}

/// Fewest bits of a Huffman code for these counts, by the sums of joined nodes; @return also the longest code word.
std::pair<std::uint64_t, int> huffman(const std::map<int, std::uint64_t>& counts) {
  using Node = std::pair<std::uint64_t, int>;  // count, longest word below
  std::priority_queue<Node, std::vector<Node>, std::greater<>> open;
  for (const auto& [symbol, count] : counts) open.emplace(count, 0);
  std::uint64_t bits = 0;
  while (open.size() > 1) {
    const Node a = open.top();
    open.pop();
    const Node b = open.top();
    open.pop();
    bits += a.first + b.first;
    open.emplace(a.first + b.first, std::max(a.second, b.second) + 1);
  }
  return {bits, open.top().second};
}

/// RFC 1951, 3.2.5, by counting: eight lengths with symbols of their own, then four symbols for each number of extra
/// bits; the last length has a symbol of its own.
std::pair<int, int> symbol_and_extra_bits(int length) {
  if (length == 258) return {285, 0};
  int symbol = 257, extra = 0, first = 3;
  for (int k = 0;; ++k, ++symbol) {
    extra = k < 8 ? 0 : (k - 4) / 4;
    if (length < first + (1 << extra)) return {symbol, extra};
    first += 1 << extra;
  }
}

/// Size of the file in closed form: bytes, and runs of 4 to 258 equal ones, in the best code of one block; nullopt if
/// that code has words of more than 15 bits.
std::optional<std::size_t> best_size(const std::vector<std::uint8_t>& bytes) {
  std::map<int, std::uint64_t> counts = {{256, 1}};
  std::uint64_t bits = 3 + 5 + 5 + 4 + 19 * 3 + (286 + 1) * 4;  // header of the block, and a length for each symbol
  for (std::size_t i = 0; i < bytes.size();) {
    ++counts[bytes[i]];
    const std::uint8_t byte = bytes[i++];
    for (;;) {
      std::size_t run = 0;
      while (i + run < bytes.size() && run < 258 && bytes[i + run] == byte) ++run;
      if (run < 4) break;
      const auto [symbol, extra] = symbol_and_extra_bits(static_cast<int>(run));
      ++counts[symbol];
      bits += static_cast<std::uint64_t>(extra) + 1;  // for the distance
      i += run;
    }
  }
  const auto [code_bits, longest] = huffman(counts);
  if (longest > 15) return std::nullopt;
  bits += code_bits;
  return 8 + (12 + 13) + (12 + 2 + (bits + 7) / 8 + 4) + 12;
}

void expect_same(int width, int height, const std::vector<std::uint16_t>& gray) {
  GrayPng encoder;
  int found_width = 0, found_height = 0;
  const auto found = read_by_libpng(encoder.encode(width, height, gray), found_width, found_height);
  EXPECT_EQ(found_width, width);
  EXPECT_EQ(found_height, height);
  EXPECT_EQ(found, gray);
  // Differences to the same byte of the pixel to the left (filter 1).
  const ByteBuffer& file = encoder.encode(width, height, gray);
  const std::vector<std::uint8_t> rows = filtered_rows(file, width, height);
  const std::optional<std::size_t> size = best_size(rows);
  if (size) {
    EXPECT_EQ(file.size(), *size) << width << " x " << height;
  }
}

TEST(GrayPng, MatchesLibpngPixelForPixel) {
  const Random random(1, "test");
  expect_same(1, 1, {0});
  expect_same(1, 1, {65535});
  expect_same(3, 2, {0, 1, 2, 65535, 65534, 40000});
  for (const int width : {1, 7, 255, 257, 1024}) {
    for (const int height : {1, 16, 128}) {
      const auto size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
      std::vector<std::uint16_t> empty(size, 0), noise(size), ranges(size);
      for (std::size_t i = 0; i < size; ++i) {
        const auto n = static_cast<std::uint32_t>(i);
        noise[i] = static_cast<std::uint16_t>(random.bits(0, n)[0]);
        // Smooth surfaces with noise and gaps: runs of every length.
        const double range = 8000.0 + 3000.0 * std::sin(0.01 * static_cast<double>(i)) + 15.0 * random.normal(1, n);
        ranges[i] = random.uniform(2, n / 90) < 0.3 ? 0 : static_cast<std::uint16_t>(range);
      }
      expect_same(width, height, empty);
      expect_same(width, height, noise);
      expect_same(width, height, ranges);
    }
  }
}

TEST(GrayPng, LimitsCodeLengthForSkewedCounts) {
  // Fibonacci numbers as counts give the longest Huffman codes: here 23 bits without a limit.
  std::vector<std::uint16_t> gray;
  std::uint16_t value = 0;
  int a = 1, b = 1;
  for (int symbol = 1; symbol < 24; ++symbol) {
    for (int i = 0; i < a; ++i)
      gray.push_back(value = static_cast<std::uint16_t>(value + symbol + 256 * (24 - symbol)));
    const int next = a + b;
    a = b;
    b = next;
  }
  expect_same(static_cast<int>(gray.size()), 1, gray);
}

TEST(GrayPng, HasARunOfEveryLength) {
  // Rows of one difference that ends after a given number of bytes; two runs whose length has no symbol of its own.
  for (const int step : {0, 1, 257}) {
    std::vector<std::uint16_t> gray;
    std::uint16_t value = 0;
    for (int length = 1; length <= 150; ++length) {
      for (int i = 0; i < length; ++i) gray.push_back(value = static_cast<std::uint16_t>(value + step));
      gray.push_back(value = static_cast<std::uint16_t>(value + 7 + 256 * (length % 90)));
    }
    expect_same(static_cast<int>(gray.size()), 1, gray);
  }
  // Lengths beyond the longest run need several runs.
  for (const int length : {127, 128, 129, 130, 131, 132, 258, 260, 600}) {
    std::vector<std::uint16_t> gray(static_cast<std::size_t>(length), 0);
    gray.front() = 0x0100;
    gray.push_back(5);
    expect_same(static_cast<int>(gray.size()), 1, gray);
    expect_same(1, static_cast<int>(gray.size()), gray);
  }
}

TEST(GrayPng, EncodesNoisyImagesOfEverySize) {
  const Random random(3, "test");
  GrayPng once;  // keeps its memory, and may not take old bytes for new ones
  for (int width = 1; width <= 40; ++width) {
    std::vector<std::uint16_t> gray(static_cast<std::size_t>(width) * 3);
    for (std::size_t i = 0; i < gray.size(); ++i)
      gray[i] =
          static_cast<std::uint16_t>(random.bits(static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(i))[0]);
    expect_same(width, 3, gray);
    int found_width = 0, found_height = 0;
    EXPECT_EQ(read_by_libpng(once.encode(width, 3, gray), found_width, found_height), gray);
    EXPECT_EQ(found_width, width);
  }
}

TEST(GrayPng, CompressesNoisyRanges) {
  const Random random(1, "test");
  std::vector<std::uint16_t> ranges(1024 * 128);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    ranges[i] = static_cast<std::uint16_t>(9000.0 + 15.0 * random.normal(0, static_cast<std::uint32_t>(i)));
  }
  GrayPng encoder;
  // Differences of two draws of 15 units have log2(15 sqrt(2) sqrt(2 pi e)) = 6.5 bits of 16; coded byte by byte, as
  // PNG does, the sign in the high byte and the magnitude in the low one cost about two bits more.
  EXPECT_LT(static_cast<double>(encoder.encode(1024, 128, ranges).size()),
            0.55 * 2.0 * static_cast<double>(ranges.size()));
}

TEST(GrayPng, RefusesMismatchedSizes) {
  GrayPng encoder;
  EXPECT_THROW(encoder.encode(2, 2, std::vector<std::uint16_t>(3)), std::invalid_argument);
  EXPECT_THROW(encoder.encode(2, 2, std::vector<std::uint16_t>(5)), std::invalid_argument);
  EXPECT_THROW(encoder.encode(0, 3, {}), std::invalid_argument);
  EXPECT_THROW(encoder.encode(3, 0, {}), std::invalid_argument);
  EXPECT_THROW(encoder.encode(-2, -2, std::vector<std::uint16_t>(4)), std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet::sim
