// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/png.hpp"

#include <png.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace swiftlet::sim {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& reason) {
  throw std::runtime_error(path.string() + ": cannot write picture: " + reason);
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

/// libpng reports errors by a callback that must not return; an exception passes its C frames only if they were
/// built for it, hence setjmp here, with nothing to destroy between it and the jump.
bool encode(std::FILE* file, int width, int height, int bits, int color_type, png_bytepp rows) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_init_io(png, file);
  png_set_compression_level(png, 1);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), bits, color_type,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  if (bits == 16) png_set_swap(png);  // the file is big-endian
  png_write_image(png, rows);
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return true;
}

void write(const std::filesystem::path& path, int width, int height, int bits, int color_type, const void* data) {
  if (width <= 0 || height <= 0) fail(path, "it has no pixels");
  const std::size_t row_bytes = static_cast<std::size_t>(width) * (color_type == PNG_COLOR_TYPE_RGB ? 3 : 1) * bits / 8;
  std::vector<png_bytep> rows(static_cast<std::size_t>(height));
  auto* bytes = static_cast<png_bytep>(const_cast<void*>(data));  // libpng only reads
  for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = bytes + y * row_bytes;

  const std::filesystem::path temporary = path.string() + ".part";
  std::unique_ptr<std::FILE, CloseFile> file(std::fopen(temporary.c_str(), "wb"));
  if (!file) fail(path, std::strerror(errno));
  const bool encoded = encode(file.get(), width, height, bits, color_type, rows.data());
  const bool closed = std::fclose(file.release()) == 0;
  const int error = errno;
  std::error_code renamed;
  if (encoded && closed) std::filesystem::rename(temporary, path, renamed);
  if (!encoded || !closed || renamed) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    fail(path, renamed ? renamed.message() : std::strerror(error));
  }
}

}  // namespace

void write_png(const std::filesystem::path& path, const Image& image) {
  write(path, image.width, image.height, 8, PNG_COLOR_TYPE_RGB, image.rgb.data());
}

void write_png16(const std::filesystem::path& path, int width, int height, std::span<const std::uint16_t> gray) {
  if (gray.size() != static_cast<std::size_t>(width) * height) fail(path, "size and data do not agree");
  write(path, width, height, 16, PNG_COLOR_TYPE_GRAY, gray.data());
}

}  // namespace swiftlet::sim
