// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/png.hpp"

#include <png.h>

#include <string>
#include <vector>

#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {
namespace {

void put(png_structp png, png_bytep bytes, std::size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
}

void flush(png_structp) {}

struct Form {
  int width = 0, height = 0;
  int bits = 8;
  int color_type = PNG_COLOR_TYPE_RGB;
  double dpi = 0.0;
  int compression = 1;  // fast
};

/// libpng reports errors by a callback that must not return. Exceptions may not pass its C frames unless they are built
/// for that, hence setjmp here, with no destructors between it and the jump.
bool encode(std::string& file, const Form& form, png_bytepp rows) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, &file, put, flush);
  png_set_compression_level(png, form.compression);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_IHDR(png, info, static_cast<png_uint_32>(form.width), static_cast<png_uint_32>(form.height), form.bits,
               form.color_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (form.dpi > 0.0) {
    const auto per_m = static_cast<png_uint_32>(form.dpi / 0.0254 + 0.5);
    png_set_pHYs(png, info, per_m, per_m, PNG_RESOLUTION_METER);
  }
  png_write_info(png, info);
  if (form.bits == 16) png_set_swap(png);  // the file is big-endian
  png_write_image(png, rows);
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return true;
}

bool encode(std::string& file, const Form& form, const void* data) {
  const std::size_t row_bytes =
      static_cast<std::size_t>(form.width) * (form.color_type == PNG_COLOR_TYPE_RGB ? 3 : 1) * form.bits / 8;
  std::vector<png_bytep> rows(static_cast<std::size_t>(form.height));
  auto* bytes = static_cast<png_bytep>(const_cast<void*>(data));  // libpng only reads it
  for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = bytes + y * row_bytes;

  return encode(file, form, rows.data());
}

void write(const std::filesystem::path& path, const Form& form, const void* data) {
  if (form.width <= 0 || form.height <= 0) fail_to_write(path, "the picture has no pixels");
  std::string file;
  if (!encode(file, form, data)) fail_to_write(path, "libpng rejects the picture");
  write_file(path, file);
}

}  // namespace

void write_png(const std::filesystem::path& path, const Image& image, double dpi) {
  write(path, {image.width, image.height, 8, PNG_COLOR_TYPE_RGB, dpi, 1}, image.rgb.data());
}

std::string png_of(const Image& image) {
  std::string file;
  ENSURE(encode(file, {image.width, image.height, 8, PNG_COLOR_TYPE_RGB, 0.0, 6}, image.rgb.data()), image.width);
  return file;
}

void write_png16(const std::filesystem::path& path, int width, int height, std::span<const std::uint16_t> gray) {
  if (gray.size() != static_cast<std::size_t>(width) * height) fail_to_write(path, "size and data do not agree");
  write(path, {width, height, 16, PNG_COLOR_TYPE_GRAY, 0.0, 1}, gray.data());
}

}  // namespace swiftlet::sim
