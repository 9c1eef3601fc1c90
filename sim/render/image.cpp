// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/image.hpp"

#include <algorithm>

namespace swiftlet::sim {
namespace {

std::uint8_t to_byte(float value) { return static_cast<std::uint8_t>(std::clamp(value, 0.0F, 1.0F) * 255.0F + 0.5F); }

}  // namespace

Image::Image(int width_px, int height_px, const Rgb& color)
    : width(width_px), height(height_px), rgb(static_cast<std::size_t>(width_px) * height_px * 3) {
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = to_byte(color[static_cast<int>(i % 3)]);
}

void set_pixel(Image& image, int x, int y, const Rgb& color) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  std::uint8_t* p = image.pixel(x, y);
  for (int c = 0; c < 3; ++c) p[c] = to_byte(color[c]);
}

void blend_pixel(Image& image, int x, int y, const Rgb& color, float alpha) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  std::uint8_t* p = image.pixel(x, y);
  for (int c = 0; c < 3; ++c) p[c] = to_byte((1.0F - alpha) * static_cast<float>(p[c]) / 255.0F + alpha * color[c]);
}

void blend_rectangle(Image& image, int x, int y, int width, int height, const Rgb& color, float alpha) {
  for (int row = std::max(0, y); row < std::min(image.height, y + height); ++row) {
    for (int column = std::max(0, x); column < std::min(image.width, x + width); ++column) {
      blend_pixel(image, column, row, color, alpha);
    }
  }
}

}  // namespace swiftlet::sim
