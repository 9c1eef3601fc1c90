// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/captions.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

constexpr std::size_t kMostNames = 24;  // more would cover the picture

/// Where a color bar, its ticks and its panel lie [px].
struct BarLayout {
  float h = 0.0F;  // height of capitals
  double step = 1.0;
  std::vector<double> ticks;
  int left = 0, top = 0, panel_width = 0, panel_height = 0;
  int bar_width = 0, bar_height = 0;

  BarLayout(const Image& image, const ColorBar& bar) : h(0.85F * caption_height_px(image)) {
    step = round_down_nicely(std::max(1e-6, (bar.high - bar.low) / 4.0));
    float text_width = 0.0F;
    for (int k = static_cast<int>(std::ceil(bar.low / step - 1e-9)); k * step <= bar.high + 1e-9 * step; ++k) {
      ticks.push_back(k * step);
      text_width = std::max(text_width, text_width_px(tick_text(k * step, step), h));
    }
    bar_width = static_cast<int>(1.3F * h);
    bar_height = image.height * 45 / 100;
    panel_width = static_cast<int>(
        std::max(static_cast<float>(bar_width) + text_width + 2.5F * h, text_width_px(bar.unit, h) + 1.6F * h));
    panel_height = bar_height + static_cast<int>(4.9F * h);
    left = image.width - panel_width - static_cast<int>(h);
    top = (image.height - panel_height) / 2;
  }
};

}  // namespace

float caption_height_px(const Image& image) {
  return std::clamp(static_cast<float>(std::min(image.height, image.width)) / 56.0F, 8.0F, 40.0F);
}

double round_down_nicely(double x) {
  const double power = std::pow(10.0, std::floor(std::log10(x)));
  for (const double digit : {5.0, 2.0}) {
    if (digit * power <= x * (1.0 + 1e-9)) return digit * power;
  }
  return power;
}

std::string tick_text(double value, double step) {
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  return fmt::format("{:.{}f}", value + 0.0, decimals);
}

void draw_caption(Image& image, std::string_view left, std::string_view right) {
  const float h = caption_height_px(image);
  const float baseline = static_cast<float>(image.height) - 1.1F * h;
  draw_text(image, 1.2F * h, baseline, left, {.height_px = h});
  draw_text(image, static_cast<float>(image.width) - 1.2F * h, baseline, right,
            {.height_px = h, .align = Align::kRight});
}

void draw_scale_bar(Image& image, const View& view) {
  const float h = caption_height_px(image);
  const double pixels_per_m = view.pixels_per_m(1.0);
  const double length_m = round_down_nicely(0.2 * image.width / pixels_per_m);
  const int length = static_cast<int>(std::lround(length_m * pixels_per_m));
  const int thick = std::max(2, static_cast<int>(h / 4.0F));
  const int x = static_cast<int>(1.2F * h);
  const int y = image.height - static_cast<int>(3.6F * h);
  blend_rectangle(image, x - 2, y - 2, length + 4, thick + 4, Rgb::Constant(0.04F), 0.7F);
  blend_rectangle(image, x, y, length, thick, Rgb::Ones(), 1.0F);
  blend_rectangle(image, x, y, length / 2, thick, Rgb::Constant(0.25F), 1.0F);
  draw_text(image, static_cast<float>(x) + 0.5F * static_cast<float>(length), static_cast<float>(y) - 0.7F * h,
            tick_text(length_m, length_m) + " m", {.height_px = 0.9F * h, .align = Align::kCenter});
}

void draw_names(Image& image, const View& view, const PictureScene& picture, std::span<const std::string> names,
                double vehicle_scale) {
  const std::size_t count = std::min(names.size(), picture.states.size());
  if (count > kMostNames) return;
  const float h = 0.9F * caption_height_px(image);
  for (std::size_t v = 0; v < count; ++v) {
    const auto at = view.project(picture.states[v].p_world_m);
    if (!at || at->x() < 0 || at->y() < 0 || at->x() > image.width || at->y() > image.height) continue;
    const double lift = 0.35 * vehicle_scale * view.pixels_per_m(at->z()) + 1.0 * h;
    const Rgb color = 0.75F * vehicle_color(static_cast<VehicleId>(v)) + Rgb::Constant(0.25F);
    draw_text(image, static_cast<float>(at->x()), static_cast<float>(at->y() - std::min(lift, 0.2 * image.height)),
              names[v], {.height_px = h, .color = color, .align = Align::kCenter});
  }
}

void draw_legend(Image& image, std::span<const Overlay::Key> keys) {
  std::vector<Overlay::Key> shown;
  for (const Overlay::Key& key : keys) {
    const auto same = [&](const Overlay::Key& other) { return other.meaning == key.meaning; };
    if (std::none_of(shown.begin(), shown.end(), same)) shown.push_back(key);
  }
  if (shown.empty()) return;
  const float h = 0.85F * caption_height_px(image);
  const int line = static_cast<int>(2.0F * h), margin = static_cast<int>(h);
  float width = 0.0F;
  for (const Overlay::Key& key : shown) width = std::max(width, text_width_px(key.meaning, h));
  blend_rectangle(image, margin, margin, static_cast<int>(width + 4.0F * h),
                  line * static_cast<int>(shown.size()) + static_cast<int>(0.8F * h), Rgb::Constant(0.04F), 0.6F);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const int top = margin + static_cast<int>(0.7F * h) + static_cast<int>(i) * line;
    blend_rectangle(image, margin + static_cast<int>(0.8F * h), top, static_cast<int>(1.2F * h),
                    static_cast<int>(1.2F * h), shown[i].color.head<3>(), 1.0F);
    draw_text(image, static_cast<float>(margin) + 2.9F * h, static_cast<float>(top) + 1.1F * h, shown[i].meaning,
              {.height_px = h, .halo_alpha = 0.0F});
  }
}

int color_bar_width_px(const Image& image, const ColorBar& bar) {
  const BarLayout layout(image, bar);
  return image.width - layout.left;
}

void draw_color_bar(Image& image, const ColorBar& bar) {
  const BarLayout layout(image, bar);
  const float h = layout.h;
  blend_rectangle(image, layout.left, layout.top, layout.panel_width, layout.panel_height, Rgb::Constant(0.04F), 0.6F);
  draw_text(image, static_cast<float>(layout.left) + 0.8F * h, static_cast<float>(layout.top) + 1.8F * h, bar.unit,
            {.height_px = h, .halo_alpha = 0.0F});

  const int bar_left = layout.left + static_cast<int>(0.8F * h);
  const int bar_top = layout.top + static_cast<int>(3.6F * h);
  for (int y = 0; y < layout.bar_height; ++y) {
    const float s = 1.0F - (static_cast<float>(y) + 0.5F) / static_cast<float>(layout.bar_height);
    blend_rectangle(image, bar_left, bar_top + y, layout.bar_width, 1, bar.color(s), 1.0F);
  }
  for (const double tick : layout.ticks) {
    const double s = (tick - bar.low) / (bar.high - bar.low);
    const int y = bar_top + static_cast<int>(std::lround((1.0 - s) * (layout.bar_height - 1)));
    const int bar_right = bar_left + layout.bar_width;
    blend_rectangle(image, bar_right, y, static_cast<int>(0.5F * h), 1, Rgb::Ones(), 1.0F);
    draw_text(image, static_cast<float>(bar_right) + 0.9F * h, static_cast<float>(y) + 0.5F * h,
              tick_text(tick, layout.step), {.height_px = h, .halo_alpha = 0.0F});
  }
}

Image draw_depth_image(const DepthImage& depth, double max_range_m) {
  if (max_range_m <= 0.0) {  // most of what is seen, up to a round number
    std::vector<float> seen;
    for (const float d : depth.depth_m) {
      if (d > 0.0F) seen.push_back(d);
    }
    max_range_m = 10.0;
    if (!seen.empty()) {
      const auto nth = seen.begin() + static_cast<std::ptrdiff_t>(0.92 * static_cast<double>(seen.size() - 1));
      std::nth_element(seen.begin(), nth, seen.end());
      const double step = round_down_nicely(std::max(0.5, static_cast<double>(*nth)) / 4.0);
      max_range_m = step * std::ceil(*nth / step);
    }
  }
  Image image(depth.width, depth.height);
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      const float d = depth.at(x, y);
      set_pixel(image, x, y, d > 0.0F ? turbo_like(d / static_cast<float>(max_range_m)) : Rgb::Constant(0.16F));
    }
  }
  draw_color_bar(image, {turbo_like, 0.0, max_range_m, "depth [m]"});
  return image;
}

}  // namespace swiftlet::sim
