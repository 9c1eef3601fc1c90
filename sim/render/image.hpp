// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>
#include <vector>

#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {

/// A picture: 8-bit sRGB, row 0 is the top.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< (height x width x 3)

  Image() = default;
  Image(int width_px, int height_px, const Rgb& color = Rgb::Zero());
  std::uint8_t* pixel(int x, int y) { return rgb.data() + 3 * (static_cast<std::size_t>(y) * width + x); }
  const std::uint8_t* pixel(int x, int y) const { return rgb.data() + 3 * (static_cast<std::size_t>(y) * width + x); }
};

/// Metric depth along the optical axis [m]; 0: no surface. Row 0 is the top.
struct DepthImage {
  int width = 0;
  int height = 0;
  std::vector<float> depth_m;  ///< (height x width)

  float at(int x, int y) const { return depth_m[static_cast<std::size_t>(y) * width + x]; }
};

// Two-dimensional drawing, clipped to the image; y grows downwards.
void set_pixel(Image& image, int x, int y, const Rgb& color);
/// Blends `color` with opacity `alpha` over a pixel.
void blend_pixel(Image& image, int x, int y, const Rgb& color, float alpha);
void blend_rectangle(Image& image, int x, int y, int width, int height, const Rgb& color, float alpha);

enum class Align { kLeft, kCenter, kRight };

inline constexpr float kCapitalOfFont = 0.729F;  ///< height of a capital letter, as a share of the font size

/// Style of a text: `height_px` is the height of a capital letter; the halo keeps it readable on any background.
struct TextStyle {
  float height_px = 12.0F;
  Rgb color = Rgb::Constant(0.08F);
  Align align = Align::kLeft;
  float halo_alpha = 0.85F;
  Rgb halo = Rgb::Ones();
};

/// Writes one line of UTF-8 in DejaVu Sans, which is built into the program. (x, y) is the left (center, right) end of
/// the baseline.
void draw_text(Image& image, float x, float y, std::string_view text, const TextStyle& style);
float text_width_px(std::string_view text, float height_px);

}  // namespace swiftlet::sim
