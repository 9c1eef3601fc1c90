// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "sim/render/image.hpp"
#include "swiftlet/sim/plot/svg_writer.hpp"

namespace swiftlet::sim {

using PixelPoint = Eigen::Vector2f;  ///< x right, y down

/// Upright rectangle [px], y down.
struct Box {
  float left = 0.0F, top = 0.0F, width = 0.0F, height = 0.0F;
  float right() const { return left + width; }
  float bottom() const { return top + height; }
};

/// A surface for pictures, lines and text. Coordinates in pixels, y down, with fractions. Layouts are equal on all
/// kinds.
class Canvas {
 public:
  Canvas(int width_px, int height_px) : width_px_(width_px), height_px_(height_px) {}
  virtual ~Canvas() = default;
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }

  /// Copies the pixels of an image, with its upper left corner at (left, top).
  virtual void picture(int left, int top, const Image& image) = 0;
  virtual void rectangle(const Box& box, const Rgb& color, float alpha = 1.0F) = 0;
  /// Line from a_px to b_px, with round ends.
  virtual void line(const PixelPoint& a_px, const PixelPoint& b_px, float width_px, const Rgb& color) = 0;
  /// @param radius_px  radius of the center line of the stroke
  virtual void ring(const PixelPoint& center_px, float radius_px, float width_px, const Rgb& color) = 0;
  void disc(const PixelPoint& center_px, float radius_px, const Rgb& color) {
    ring(center_px, 0.5F * radius_px, radius_px, color);
  }
  /// One line of text, with its baseline's left (center, right) end at `at_px`.
  virtual void text(const PixelPoint& at_px, std::string_view content, const TextStyle& style) = 0;

 private:
  int width_px_ = 0;
  int height_px_ = 0;
};

/// Draws into an image owned by the caller.
class PixelCanvas : public Canvas {
 public:
  explicit PixelCanvas(Image& image) : Canvas(image.width, image.height), image_(image) {}

  void picture(int left, int top, const Image& image) override;
  void rectangle(const Box& box, const Rgb& color, float alpha) override;
  void line(const PixelPoint& a_px, const PixelPoint& b_px, float width_px, const Rgb& color) override;
  void ring(const PixelPoint& center_px, float radius_px, float width_px, const Rgb& color) override;
  void text(const PixelPoint& at_px, std::string_view content, const TextStyle& style) override;

 private:
  Image& image_;
};

/// Writes an SVG file: text remains text, pictures are embedded as PNG.
class SvgCanvas : public Canvas {
 public:
  /// @param dpi    pixels per 25.4 mm, for the printed size of the file
  /// @param title  title for screen readers
  SvgCanvas(int width_px, int height_px, double dpi, std::string_view title);

  void picture(int left, int top, const Image& image) override;
  void rectangle(const Box& box, const Rgb& color, float alpha) override;
  void line(const PixelPoint& a_px, const PixelPoint& b_px, float width_px, const Rgb& color) override;
  void ring(const PixelPoint& center_px, float radius_px, float width_px, const Rgb& color) override;
  void text(const PixelPoint& at_px, std::string_view content, const TextStyle& style) override;
  /// Returns the whole file and empties the canvas.
  std::string finish() { return svg_.finish(); }

 private:
  plot::SvgWriter svg_;
};

/// A drawing that can be rendered on every kind of canvas.
struct Figure {
  int width_px = 0;
  int height_px = 0;
  std::function<void(Canvas&)> paint;

  /// @param page  background color
  Image pixels(const Rgb& page) const;
  std::string svg(double dpi, std::string_view title) const;
};

}  // namespace swiftlet::sim
