// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/png.hpp"

#include <png.h>

#include <string>
#include <vector>

#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {
namespace {

/// [-] Compression levels of zlib: 1 writes fast, 6 gives smaller files.
constexpr int kFastCompression = 1, kSmallCompression = 6;
constexpr double kMetersPerInch = 0.0254;

void append_bytes(png_structp png, png_bytep bytes, std::size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
}

void flush(png_structp) {}

struct PngFormat {
  int width = 0, height = 0;
  int bits = 8;  // per channel
  int color_type = PNG_COLOR_TYPE_RGB;
  double dpi = 0.0;  // 0: not stored
  int compression = kFastCompression;
};

/// False when libpng reports an error. Its error callback must not return, and exceptions must not propagate through
/// its C code, so it jumps back here. No object with a destructor may live between setjmp and the jump.
bool encode(std::string& file, const PngFormat& format, png_bytepp rows) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, &file, append_bytes, flush);
  png_set_compression_level(png, format.compression);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_IHDR(png, info, static_cast<png_uint_32>(format.width), static_cast<png_uint_32>(format.height), format.bits,
               format.color_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (format.dpi > 0.0) {
    const auto per_m = static_cast<png_uint_32>(format.dpi / kMetersPerInch + 0.5);
    png_set_pHYs(png, info, per_m, per_m, PNG_RESOLUTION_METER);
  }
  png_write_info(png, info);
  if (format.bits == 16) png_set_swap(png);  // PNG is big-endian
  png_write_image(png, rows);
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return true;
}

bool encode(std::string& file, const PngFormat& format, const void* data) {
  const std::size_t row_bytes =
      static_cast<std::size_t>(format.width) * (format.color_type == PNG_COLOR_TYPE_RGB ? 3 : 1) * format.bits / 8;
  std::vector<png_bytep> rows(static_cast<std::size_t>(format.height));
  auto* bytes = static_cast<png_bytep>(const_cast<void*>(data));  // libpng only reads it
  for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = bytes + y * row_bytes;

  return encode(file, format, rows.data());
}

void write(const std::filesystem::path& path, const PngFormat& format, const void* data) {
  if (format.width <= 0 || format.height <= 0) fail_to_write(path, "the picture has no pixels");
  std::string file;
  if (!encode(file, format, data)) fail_to_write(path, "libpng cannot encode the picture");
  write_file(path, file);
}

}  // namespace

void write_png(const std::filesystem::path& path, const Image& image, double dpi) {
  write(path, {image.width, image.height, 8, PNG_COLOR_TYPE_RGB, dpi, kFastCompression}, image.rgb.data());
}

std::string png_of(const Image& image) {
  std::string file;
  ENSURE(encode(file, {image.width, image.height, 8, PNG_COLOR_TYPE_RGB, 0.0, kSmallCompression}, image.rgb.data()),
         image.width);
  return file;
}

void write_png16(const std::filesystem::path& path, int width, int height, std::span<const std::uint16_t> gray) {
  if (gray.size() != static_cast<std::size_t>(width) * height)
    fail_to_write(path, "the number of pixels does not match width and height");
  write(path, {width, height, 16, PNG_COLOR_TYPE_GRAY, 0.0, kFastCompression}, gray.data());
}

}  // namespace swiftlet::sim
