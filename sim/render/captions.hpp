// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "sim/render/cameras.hpp"
#include "swiftlet/sim/render/image.hpp"

namespace swiftlet::sim {

/// Height of capitals that suits a picture [px].
float caption_height_px(const Image& image);

/// Two lines of text at the lower edge: at the left what it is, at the right when.
void draw_caption(Image& image, std::string_view left, std::string_view right);
/// A bar of round length in the lower left corner, above the caption. For parallel projections.
void draw_scale_bar(Image& image, const View& view);
/// Each vehicle's name in its color, above it. Teams of more than 24 have none: they would cover the picture.
void draw_names(Image& image, const View& view, const PictureScene& picture, std::span<const std::string> names,
                double vehicle_scale);

/// What colors mean, on a dark panel in the upper left corner; each meaning once.
void draw_legend(Image& image, std::span<const Overlay::Key> keys);

/// A bar that explains colors.
struct ColorBar {
  std::function<Rgb(float)> color;  ///< of s in 0..1
  double low = 0.0;                 ///< value at s = 0
  double high = 1.0;
  std::string unit;
};
/// Width at the right edge of the picture that the bar with its panel takes [px].
int color_bar_width_px(const Image& image, const ColorBar& bar);
/// On a dark panel at the right edge of the picture.
void draw_color_bar(Image& image, const ColorBar& bar);

/// 1, 2 or 5 times a power of ten, the largest not above x (x > 0).
double round_down_nicely(double x);
/// Shortest decimal of a tick at steps of `step`.
std::string tick_text(double value, double step);

/// The picture of a depth image: colors of turbo_like, with a color bar; nothing there is gray.
Image draw_depth_image(const DepthImage& depth, double max_range_m);

}  // namespace swiftlet::sim
