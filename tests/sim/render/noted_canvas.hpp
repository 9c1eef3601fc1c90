// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "sim/render/canvas.hpp"

namespace swiftlet::sim {

/// Notes where texts, rectangles and rings are drawn.
class NotedCanvas : public Canvas {
 public:
  struct Text {
    std::string content;
    Box box;
  };
  using Canvas::Canvas;
  void picture(int, int, const Image&) override {}
  void rectangle(const Box& box, const Rgb&, float) override { rectangles.push_back(box); }
  void line(const PixelPoint&, const PixelPoint&, float, const Rgb&) override {}
  void ring(const PixelPoint& center_px, float radius_px, float, const Rgb&) override {
    rings.push_back({center_px.x(), center_px.y(), radius_px});
  }
  void text(const PixelPoint& at_px, std::string_view content, const TextStyle& style) override {
    const float width = text_width_px(content, style.height_px);
    const float share = style.align == Align::kLeft ? 0.0F : style.align == Align::kCenter ? 0.5F : 1.0F;
    texts.push_back({std::string(content),
                     {at_px.x() - share * width, at_px.y() - style.height_px, width, 1.3F * style.height_px}});
  }
  bool says(const std::string& content) const {
    return std::any_of(texts.begin(), texts.end(), [&](const Text& text) { return text.content == content; });
  }

  std::vector<Box> rectangles;
  std::vector<Eigen::Vector3f> rings;
  std::vector<Text> texts;
};

}  // namespace swiftlet::sim
