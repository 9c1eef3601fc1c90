// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/render/canvas.hpp"

namespace swiftlet::sim {

/// Notes what is drawn where.
class NotedCanvas : public Canvas {
 public:
  struct Text {
    std::string content;
    Box box;
    Eigen::Vector2f at_px = Eigen::Vector2f::Zero();
    TextStyle style = {};
  };
  using Canvas::Canvas;
  void picture(int left, int top, const Image& image) override {
    pictures.push_back({static_cast<float>(left), static_cast<float>(top), static_cast<float>(image.width),
                        static_cast<float>(image.height)});
  }
  void rectangle(const Box& box, const Rgb& color, float alpha) override {
    rectangles.push_back(box);
    colors.push_back(color);
    alphas.push_back(alpha);
  }
  void line(const PixelPoint& a_px, const PixelPoint& b_px, float width_px, const Rgb& color) override {
    lines.push_back({a_px, b_px});
    line_widths.push_back(width_px);
    colors.push_back(color);
  }
  void ring(const PixelPoint& center_px, float radius_px, float width_px, const Rgb& color) override {
    rings.push_back({center_px.x(), center_px.y(), radius_px});
    ring_widths.push_back(width_px);
    colors.push_back(color);
  }
  void text(const PixelPoint& at_px, std::string_view content, const TextStyle& style) override {
    const float width = text_width_px(content, style.height_px);
    const float share = style.align == Align::kLeft ? 0.0F : style.align == Align::kCenter ? 0.5F : 1.0F;
    texts.push_back({std::string(content),
                     {at_px.x() - share * width, at_px.y() - style.height_px, width, 1.3F * style.height_px},
                     at_px,
                     style});
  }
  bool says(const std::string& content) const {
    return std::any_of(texts.begin(), texts.end(), [&](const Text& text) { return text.content == content; });
  }

  std::vector<Box> pictures, rectangles;
  std::vector<float> alphas, line_widths, ring_widths;  // per rectangle, line, ring
  std::vector<Rgb> colors;
  std::vector<std::pair<Eigen::Vector2f, Eigen::Vector2f>> lines;
  std::vector<Eigen::Vector3f> rings;
  std::vector<Text> texts;
};

}  // namespace swiftlet::sim
