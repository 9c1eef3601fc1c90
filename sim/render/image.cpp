// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/render/image.hpp"

#include <algorithm>
#include <cmath>

#include "sim/render/stroke_font.hpp"

namespace swiftlet::sim {
namespace {

std::uint8_t to_byte(float value) { return static_cast<std::uint8_t>(std::clamp(value, 0.0F, 1.0F) * 255.0F + 0.5F); }

float distance_to_segment(const Eigen::Vector2f& p, const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
  const Eigen::Vector2f ab = b - a;
  const float length_sq = ab.squaredNorm();
  const float s = length_sq > 0.0F ? std::clamp((p - a).dot(ab) / length_sq, 0.0F, 1.0F) : 0.0F;
  return (p - a - s * ab).norm();
}

/// Distance of every pixel around the text to its nearest stroke, capped at `reach_px`.
struct DistanceField {
  int x0 = 0, y0 = 0, width = 0, height = 0;
  std::vector<float> distance_px;

  void add(const Eigen::Vector2f& a, const Eigen::Vector2f& b, float reach_px) {
    const int left = std::max(0, static_cast<int>(std::floor(std::min(a.x(), b.x()) - reach_px)) - x0);
    const int right = std::min(width - 1, static_cast<int>(std::ceil(std::max(a.x(), b.x()) + reach_px)) - x0);
    const int top = std::max(0, static_cast<int>(std::floor(std::min(a.y(), b.y()) - reach_px)) - y0);
    const int bottom = std::min(height - 1, static_cast<int>(std::ceil(std::max(a.y(), b.y()) + reach_px)) - y0);
    for (int y = top; y <= bottom; ++y) {
      for (int x = left; x <= right; ++x) {
        const Eigen::Vector2f center(static_cast<float>(x0 + x) + 0.5F, static_cast<float>(y0 + y) + 0.5F);
        float& d = distance_px[static_cast<std::size_t>(y) * width + x];
        d = std::min(d, distance_to_segment(center, a, b));
      }
    }
  }
};

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

float text_width_px(std::string_view text, float height_px) {
  const float scale = height_px / kFontCapHeight;
  float width = 0.0F;
  for (const char c : text) width += font_advance(c) * scale;
  return std::max(0.0F, width - kFontGap * scale);
}

void draw_text(Image& image, float x, float y, std::string_view text, const TextStyle& style) {
  const float scale = style.height_px / kFontCapHeight;
  const float stroke_px = std::max(0.62F, 0.075F * style.height_px);  // half width of a stroke
  const float halo_px = stroke_px + std::max(1.5F, 0.16F * style.height_px);
  const float reach_px = halo_px + 1.5F;
  const float width = text_width_px(text, style.height_px);
  if (style.align == Align::kCenter) x -= 0.5F * width;
  if (style.align == Align::kRight) x -= width;

  DistanceField field;
  field.x0 = static_cast<int>(std::floor(x - reach_px));
  field.y0 = static_cast<int>(std::floor(y - style.height_px - reach_px - scale));
  field.width = static_cast<int>(std::ceil(width + 2.0F * reach_px)) + 2;
  field.height = static_cast<int>(std::ceil(style.height_px * 1.4F + 2.0F * reach_px)) + 2;
  field.distance_px.assign(static_cast<std::size_t>(field.width) * field.height, 1e3F);

  float pen = x;
  for (const char c : text) {
    for (const auto& stroke : font_strokes(c)) {
      const auto to_picture = [&](const Eigen::Vector2f& p) -> Eigen::Vector2f {
        return {pen + p.x() * scale, y - p.y() * scale};
      };
      for (std::size_t i = 0; i + 1 < stroke.size(); ++i) {
        field.add(to_picture(stroke[i]), to_picture(stroke[i + 1]), reach_px);
      }
    }
    pen += font_advance(c) * scale;
  }

  for (int row = 0; row < field.height; ++row) {
    for (int column = 0; column < field.width; ++column) {
      const float d = field.distance_px[static_cast<std::size_t>(row) * field.width + column];
      if (d >= reach_px) continue;
      const float halo = style.halo_alpha * std::clamp((halo_px + 0.5F - d) / (halo_px - stroke_px), 0.0F, 1.0F);
      const float ink = std::clamp(stroke_px + 0.5F - d, 0.0F, 1.0F);
      blend_pixel(image, field.x0 + column, field.y0 + row, style.halo, halo);
      blend_pixel(image, field.x0 + column, field.y0 + row, style.color, ink);
    }
  }
}

}  // namespace swiftlet::sim
