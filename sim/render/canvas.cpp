// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/canvas.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "sim/render/png.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

std::string hex_of(const Rgb& color) {
  const auto byte = [&](int channel) { return std::lround(255.0F * std::clamp(color[channel], 0.0F, 1.0F)); };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(0), byte(1), byte(2));
}

plot::PointPx point_of(const Eigen::Vector2f& p) { return {p.x(), p.y()}; }

/// Colors pixels by their distance from a shape: `distance_px(center of the pixel)`.
void stroke(Image& image, const Eigen::AlignedBox2f& around_px, float width_px, const Rgb& color,
            const std::function<float(const Eigen::Vector2f&)>& distance_px) {
  const float reach = 0.5F * width_px + 1.0F;
  const auto first = [&](int axis) { return std::max(0, static_cast<int>(around_px.min()[axis] - reach)); };
  const auto end = [&](int axis, int size) {
    return std::min(size, static_cast<int>(std::ceil(around_px.max()[axis] + reach)) + 1);
  };
  for (int y = first(1); y < end(1, image.height); ++y) {
    for (int x = first(0); x < end(0, image.width); ++x) {
      const float d = distance_px({static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F});
      const float ink = std::clamp(0.5F * width_px + 0.5F - d, 0.0F, 1.0F);
      if (ink > 0.0F) blend_pixel(image, x, y, color, ink);
    }
  }
}

int whole(float px) { return static_cast<int>(std::lround(px)); }

}  // namespace

void PixelCanvas::picture(int left, int top, const Image& image) {
  const int first = std::max(0, -left), end = std::min(image.width, image_.width - left);
  if (first >= end) return;
  for (int y = std::max(0, -top); y < std::min(image.height, image_.height - top); ++y) {
    std::copy(image.pixel(first, y), image.pixel(first, y) + 3 * static_cast<std::ptrdiff_t>(end - first),
              image_.pixel(left + first, top + y));
  }
}

void PixelCanvas::rectangle(const Box& box, const Rgb& color, float alpha) {
  const int left = whole(box.left), top = whole(box.top);
  blend_rectangle(image_, left, top, std::max(1, whole(box.right()) - left), std::max(1, whole(box.bottom()) - top),
                  color, alpha);
}

void PixelCanvas::line(const PixelPoint& a_px, const PixelPoint& b_px, float width_px, const Rgb& color) {
  const Eigen::Vector2f ab = b_px - a_px;
  const float length_sq = std::max(1e-6F, ab.squaredNorm());
  stroke(image_, Eigen::AlignedBox2f(a_px.cwiseMin(b_px), a_px.cwiseMax(b_px)), width_px, color,
         [&](const Eigen::Vector2f& p) {
           return (p - a_px - std::clamp((p - a_px).dot(ab) / length_sq, 0.0F, 1.0F) * ab).norm();
         });
}

void PixelCanvas::ring(const PixelPoint& center_px, float radius_px, float width_px, const Rgb& color) {
  const Eigen::Vector2f reach = Eigen::Vector2f::Constant(radius_px);
  stroke(image_, Eigen::AlignedBox2f(center_px - reach, center_px + reach), width_px, color,
         [&](const Eigen::Vector2f& p) { return std::abs((p - center_px).norm() - radius_px); });
}

void PixelCanvas::text(const PixelPoint& at_px, std::string_view content, const TextStyle& style) {
  draw_text(image_, at_px.x(), at_px.y(), content, style);
}

SvgCanvas::SvgCanvas(int width_px, int height_px, double dpi, std::string_view title)
    : Canvas(width_px, height_px), svg_(width_px, height_px, title, 25.4 * width_px / dpi) {}

void SvgCanvas::picture(int left, int top, const Image& image) {
  if (image.width > 0 && image.height > 0) svg_.picture(left, top, image.width, image.height, png_of(image));
}

void SvgCanvas::rectangle(const Box& box, const Rgb& color, float alpha) {
  std::string attributes = "fill=\"" + hex_of(color) + "\"";
  if (alpha < 1.0F) attributes += fmt::format(" fill-opacity=\"{:.2f}\"", alpha);
  svg_.rect(box.left, box.top, box.width, box.height, attributes);
}

void SvgCanvas::line(const PixelPoint& a_px, const PixelPoint& b_px, float width_px, const Rgb& color) {
  svg_.segment(point_of(a_px), point_of(b_px),
               fmt::format("stroke=\"{}\" stroke-width=\"{:.1f}\" stroke-linecap=\"round\"", hex_of(color), width_px));
}

void SvgCanvas::ring(const PixelPoint& center_px, float radius_px, float width_px, const Rgb& color) {
  svg_.circle(point_of(center_px), radius_px,
              fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"{:.1f}\"", hex_of(color), width_px));
}

void SvgCanvas::text(const PixelPoint& at_px, std::string_view content, const TextStyle& style) {
  std::string attributes = fmt::format("fill=\"{}\"", hex_of(style.color));
  if (style.halo_alpha > 0.0F) {
    attributes += fmt::format(
        " stroke=\"{}\" stroke-opacity=\"{:.2f}\" stroke-width=\"{:.1f}\" stroke-linejoin=\"round\" "
        "paint-order=\"stroke\"",
        hex_of(style.halo), style.halo_alpha, 0.3F * style.height_px);
  }
  const plot::Anchor anchor = style.align == Align::kLeft     ? plot::Anchor::kStart
                              : style.align == Align::kCenter ? plot::Anchor::kMiddle
                                                              : plot::Anchor::kEnd;
  svg_.text_with(point_of(at_px), content, style.height_px / kCapitalOfFont, anchor, attributes);
}

Image Figure::pixels(const Rgb& page) const {
  Image image(width_px, height_px, page);
  PixelCanvas canvas(image);
  paint(canvas);
  return image;
}

std::string Figure::svg(double dpi, std::string_view title) const {
  SvgCanvas canvas(width_px, height_px, dpi, title);
  paint(canvas);
  return canvas.finish();
}

}  // namespace swiftlet::sim
