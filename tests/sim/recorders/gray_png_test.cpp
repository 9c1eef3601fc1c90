// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/gray_png.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstring>

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

void expect_same(int width, int height, const std::vector<std::uint16_t>& gray) {
  GrayPng encoder;
  int found_width = 0, found_height = 0;
  const auto found = read_by_libpng(encoder.encode(width, height, gray), found_width, found_height);
  EXPECT_EQ(found_width, width);
  EXPECT_EQ(found_height, height);
  EXPECT_EQ(found, gray);
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
