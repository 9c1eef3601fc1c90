// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/captions.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

// [-] Largest number of vehicles whose names are shown. Larger values hide more of the picture.
constexpr std::size_t kMaxNames = 24;
// [-] Font size of the sidebar, relative to the font size of the picture.
constexpr float kSidebarText = 0.85F;
// [font sizes] Width from which the text of a legend row is broken into lines. Larger values make the sidebar wider.
constexpr float kWidestMeaning = 14.0F;
// [font sizes] Width of the symbol of a legend row, and distance of the text from the left margin.
constexpr float kSampleWidth = 2.2F, kMeaningLeft = 3.9F;
// [font sizes] Width of the color bar, distance of the tick labels from it, and least distance of two ticks.
constexpr float kBarWidth = 1.3F, kTickLeft = 0.9F, kClosestTicks = 2.2F;
constexpr double kPointsPerInch = 72.0;

/// Breaks at blanks, so that only single long words exceed the width.
std::vector<std::string> broken(std::string_view text, float text_px, float widest_px) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!lines.empty()) {
      const std::string longer = lines.back() + " " + std::string(word);
      if (text_width_px(longer, text_px) <= widest_px) {
        lines.back() = longer;
        continue;
      }
    }
    lines.emplace_back(word);
  }
  return lines;
}

double tick_step_of(const ColorBar& bar) { return round_down_nicely(std::max(1e-6, (bar.high - bar.low) / 4.0)); }

std::vector<double> ticks_of(const ColorBar& bar, double step) {
  std::vector<double> ticks;
  for (int k = static_cast<int>(std::ceil(bar.low / step - 1e-9)); k * step <= bar.high + 1e-9 * step; ++k)
    ticks.push_back(k * step);
  return ticks;
}

float bar_width_px(const ColorBar& bar, float h) {
  const double step = tick_step_of(bar);
  float digits = text_width_px("-88.8", h);
  for (const double tick : ticks_of(bar, step)) digits = std::max(digits, text_width_px(tick_text(tick, step), h));
  return std::max((kBarWidth + kTickLeft) * h + digits, text_width_px(bar.unit, h));
}

void draw_sample(Canvas& canvas, const Box& box, const LegendEntry& entry) {
  const float middle = box.top + 0.5F * box.height, width = 0.22F * box.height;
  const Eigen::Vector2f center(box.left + 0.5F * box.width, middle);
  const auto dash = [&](float from, float to) {
    canvas.line({box.left + from * box.width, middle}, {box.left + to * box.width, middle}, width, entry.color);
  };
  switch (entry.sample) {
    case Sample::kSquare:
      canvas.rectangle({center.x() - 0.5F * box.height, box.top, box.height, box.height}, entry.color);
      return;
    case Sample::kDisc:
      canvas.disc(center, 0.5F * box.height, entry.color);
      return;
    case Sample::kDot:
      canvas.disc(center, 0.3F * box.height, entry.color);
      return;
    case Sample::kLine:
      dash(0.05F, 0.95F);
      return;
    case Sample::kDashes:
      for (const float from : {0.05F, 0.41F, 0.77F}) dash(from, from + 0.18F);
      return;
  }
}

/// Intersection area of two boxes.
float overlap_px(const Box& a, const Box& b) {
  const float width = std::min(a.right(), b.right()) - std::max(a.left, b.left);
  const float height = std::min(a.bottom(), b.bottom()) - std::max(a.top, b.top);
  return std::max(0.0F, width) * std::max(0.0F, height);
}

/// Position of a label of this size beside a vehicle that covers the least area of obstacles and stays within the
/// picture.
Box place_label(const Eigen::Vector2f& vehicle, float reach_px, const Eigen::Vector2f& size,
                std::span<const Box> obstacles, const Box& picture) {
  Box best;
  float least = std::numeric_limits<float>::infinity();
  for (const float farther : {0.0F, 1.0F, 2.0F}) {
    const float reach = reach_px + farther * size.y();
    const Eigen::Vector2f aside(reach + 0.5F * size.x(), 0.0F), up(0.0F, -reach - 0.5F * size.y());
    for (const Eigen::Vector2f& offset : {up, Eigen::Vector2f(-up), aside, Eigen::Vector2f(-aside)}) {
      const Eigen::Vector2f corner = vehicle + offset - 0.5F * size;
      const Box box{corner.x(), corner.y(), size.x(), size.y()};
      float covered = size.x() * size.y() - overlap_px(box, picture);
      for (const Box& obstacle : obstacles) covered += overlap_px(box, obstacle);
      if (covered < least - 1.0F) {  // better by more than a pixel
        least = covered;
        best = box;
      }
    }
  }
  return best;
}

}  // namespace

TextStyle Look::text(float share, Align align) const {
  TextStyle style;
  style.height_px = share * text_px;
  style.color = ink;
  style.align = align;
  style.halo = page;
  return style;
}

Look look_of(const CameraConfig& camera) {
  Look look;
  const Eigen::Vector2i size = camera.size_px();
  if (!camera.on_paper()) {
    look.text_px = std::clamp(static_cast<float>(size.minCoeff()) / 60.0F, 8.0F, 40.0F);
    return look;
  }
  look.text_px = static_cast<float>(kCapitalOfFont * camera.text_pt * camera.dpi / kPointsPerInch);
  look.captions = false;
  look.line_scale = std::max(1.0F, static_cast<float>(camera.dpi) / 200.0F);
  return look;
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

void draw_caption(Canvas& canvas, const Look& look, int width_px, std::string_view left, std::string_view right) {
  const float h = look.text_px;
  const float baseline = static_cast<float>(canvas.height_px()) - 1.1F * h;
  const float width = static_cast<float>(width_px) - 2.4F * h;
  if (text_width_px(left, h) + text_width_px(right, h) + 2.0F * h <= width)
    canvas.text({1.2F * h, baseline}, left, look.text());
  canvas.text({1.2F * h + width, baseline}, right, look.text(1.0F, Align::kRight));
}

void draw_scale_bar(Canvas& canvas, const Look& look, const View& view) {
  const float h = look.text_px;
  const double pixels_per_m = view.pixels_per_m(1.0);
  const double length_m = round_down_nicely(0.2 * view.width_px / pixels_per_m);
  const auto length = static_cast<float>(length_m * pixels_per_m);
  const Box bar{1.2F * h, static_cast<float>(view.height_px) - (look.captions ? 3.6F : 1.6F) * h, length,
                std::max(2.0F, 0.25F * h)};
  const float rim = std::max(2.0F, 0.12F * h);
  canvas.rectangle({bar.left - rim, bar.top - rim, bar.width + 2.0F * rim, bar.height + 2.0F * rim}, look.page, 0.7F);
  canvas.rectangle(bar, look.ink);
  canvas.rectangle({bar.left, bar.top, 0.5F * length, bar.height}, Rgb::Constant(0.6F));
  canvas.text({bar.left + 0.5F * length, bar.top - 0.7F * h}, tick_text(length_m, length_m) + " m",
              look.text(0.9F, Align::kCenter));
}

void draw_axes(Canvas& canvas, const Look& look, const View& view) {
  const float h = look.text_px;
  const float length = 2.6F * h;
  const Eigen::Vector2f origin(static_cast<float>(view.width_px) - 5.0F * h,
                               static_cast<float>(view.height_px) - (look.captions ? 6.4F : 4.4F) * h);
  struct Axis {
    const char* name;
    Rgb color;
    Eigen::Vector3f camera;  // direction in the camera frame: right, up, towards the camera
  };
  std::vector<Axis> axes;
  const Rgb colors[] = {{0.86F, 0.18F, 0.16F}, {0.10F, 0.60F, 0.22F}, {0.16F, 0.38F, 0.90F}};
  for (int i = 0; i < 3; ++i) {
    const char* const names[] = {"x", "y", "z"};
    axes.push_back({names[i], colors[i], view.T_camera_world.block<3, 1>(0, i).cast<float>()});
  }
  std::stable_sort(axes.begin(), axes.end(), [](const Axis& a, const Axis& b) { return a.camera.z() < b.camera.z(); });
  for (const Axis& axis : axes) {
    const Eigen::Vector2f along(axis.camera.x(), -axis.camera.y());
    if (along.norm() < 0.1F) continue;  // axis along the viewing direction
    const Eigen::Vector2f tip = origin + length * along;
    canvas.line(origin, tip, 0.32F * h, look.page);
    canvas.line(origin, tip, 0.18F * h, axis.color);
    TextStyle style = look.text(0.9F, Align::kCenter);
    const Eigen::Vector2f at = tip + 0.9F * h * along.normalized();
    canvas.text({at.x(), at.y() + 0.35F * h}, axis.name, style);
  }
}

void draw_vehicle_marks(Canvas& canvas, const Look& look, const View& view, const PictureScene& picture,
                        const VehicleMarks& marks) {
  const float h = 0.9F * look.text_px;
  const bool named = !marks.names.empty() && picture.states.size() <= kMaxNames;
  struct Named {
    std::size_t vehicle;
    Eigen::Vector2f center;
    float reach_px;
  };
  std::vector<Named> to_name;
  const auto width = static_cast<float>(view.width_px), height = static_cast<float>(view.height_px);
  // Areas of scale bar, axes and caption.
  std::vector<Box> obstacles = {{0.0F, height - 6.6F * h, 0.2F * width + 3.0F * h, 6.6F * h},
                                {width - 9.0F * h, height - 11.0F * h, 9.0F * h, 11.0F * h},
                                {0.0F, height - 2.8F * h, width, 2.8F * h}};
  for (std::size_t v = 0; v < picture.states.size(); ++v) {
    if (static_cast<VehicleId>(v) == marks.hidden_vehicle) continue;
    const auto at = view.project(picture.states[v].p_world_m);
    if (!at || at->x() < 0 || at->y() < 0 || at->x() > view.width_px || at->y() > view.height_px) continue;
    const Eigen::Vector2f center = at->head<2>().cast<float>();
    const Rgb color = vehicle_color(static_cast<VehicleId>(v));
    const float radius_m = v < marks.radii_m.size() ? marks.radii_m[v] : 0.35F;
    float radius_px = radius_m * static_cast<float>(view.pixels_per_m(at->z()));
    if (2.0F * radius_px < marks.min_px) {
      radius_px = 0.5F * marks.min_px;
      const float thick = std::min(std::max(2.0F, 0.17F * h) * look.line_scale, 0.3F * radius_px);
      canvas.ring(center, radius_px, 2.2F * thick, look.page);
      canvas.ring(center, radius_px, thick, color);
    }
    if (!named || v >= marks.names.size()) continue;
    const float reach_px = std::min(0.9F * radius_px, 0.2F * height);
    to_name.push_back({v, center, reach_px});
    obstacles.push_back({center.x() - reach_px, center.y() - reach_px, 2.0F * reach_px, 2.0F * reach_px});
  }
  for (const Named& one : to_name) {
    const std::string& name = marks.names[one.vehicle];
    const Eigen::Vector2f size(text_width_px(name, h) + h, 2.0F * h);  // with a margin of half a capital letter
    const Box box = place_label(one.center, one.reach_px, size, obstacles, {0.0F, 0.0F, width, height});
    obstacles.push_back(box);
    TextStyle style = look.text(0.9F, Align::kCenter);
    style.color = ink_of(vehicle_color(static_cast<VehicleId>(one.vehicle)));
    canvas.text({box.left + 0.5F * box.width, box.top + 1.5F * h}, name, style);
  }
}

Sample sample_of(Overlay::Kind kind, bool dashed) {
  switch (kind) {
    case Overlay::Kind::kLines:
    case Overlay::Kind::kPolyline:
      return dashed ? Sample::kDashes : Sample::kLine;
    case Overlay::Kind::kPoints:
      return Sample::kDot;
    case Overlay::Kind::kSpheres:
      return Sample::kDisc;
    case Overlay::Kind::kCubes:
    case Overlay::Kind::kTriangles:
      break;
  }
  return Sample::kSquare;
}

std::vector<LegendEntry> rows_of(std::span<const LegendEntry> entries) {
  std::vector<LegendEntry> rows;
  std::set<std::string> meanings;
  for (const LegendEntry& entry : entries) {
    if (!meanings.insert(entry.meaning).second) continue;
    const auto alike = std::find_if(rows.begin(), rows.end(), [&](const LegendEntry& row) {
      return row.sample == entry.sample && color_difference(row.color, entry.color) < kMinDifference;
    });
    if (alike == rows.end()) {
      rows.push_back(entry);
    } else {
      alike->meaning += ", " + entry.meaning;
    }
  }
  return rows;
}

int sidebar_width_px(const Sidebar& sidebar, const Look& look) {
  if (sidebar.empty()) return 0;
  const float h = kSidebarText * look.text_px;
  float width = sidebar.bar ? bar_width_px(*sidebar.bar, h) + 2.0F * h : 0.0F;
  for (const LegendEntry& row : rows_of(sidebar.entries)) {
    for (const std::string& line : broken(row.meaning, h, kWidestMeaning * h))
      width = std::max(width, text_width_px(line, h) + (kMeaningLeft + 0.8F) * h);
  }
  return static_cast<int>(std::ceil(width));
}

SidebarLayout lay_out(const Sidebar& sidebar, const Look& look, const Box& margin) {
  SidebarLayout layout;
  const float h = layout.text_px = kSidebarText * look.text_px;
  layout.line_px = 1.6F * h;
  layout.text_left_px = margin.left + kMeaningLeft * h;
  const float least_bar = sidebar.bar ? 11.0F * h : 0.0F;  // including its unit
  float top = margin.top + h;
  const std::vector<LegendEntry> rows = rows_of(sidebar.entries);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    SidebarLayout::Row row;
    row.lines = broken(rows[i].meaning, h, kWidestMeaning * h);
    row.entry = rows[i];
    row.swatch = {margin.left + h, top, kSampleWidth * h, 1.2F * h};
    row.first_baseline_px = top + 1.1F * h;
    const float height = layout.line_px * static_cast<float>(std::max<std::size_t>(1, row.lines.size()));
    const float for_the_rest = i + 1 < rows.size() ? layout.line_px : 0.0F;  // a line with the number of remaining rows
    if (top + height + for_the_rest + least_bar > margin.bottom() - 0.6F * h) {
      layout.left_out = rows.size() - i;
      break;
    }
    top += height + 0.4F * h;
    layout.rows.push_back(std::move(row));
  }
  if (layout.left_out > 0) {
    layout.left_out_baseline_px = top + 1.1F * h;
    top += layout.line_px;
  }
  if (!sidebar.bar) return layout;

  const float below = margin.bottom() - 1.2F * h;
  const float height = std::clamp(0.45F * margin.height, 4.0F * h, std::max(4.0F * h, below - top - 4.2F * h));
  if (rows.empty()) top = std::max(top, margin.top + 0.5F * (margin.height - height - 3.6F * h));
  layout.unit_baseline_px = top + 1.6F * h;
  layout.bar = {margin.left + h, layout.unit_baseline_px + 1.6F * h, kBarWidth * h, height};
  layout.tick_step = tick_step_of(*sidebar.bar);
  const double px_per_unit = height / std::max(1e-9, sidebar.bar->high - sidebar.bar->low);
  while (layout.tick_step * px_per_unit < kClosestTicks * h)
    layout.tick_step = round_down_nicely(2.5 * layout.tick_step);
  layout.ticks = ticks_of(*sidebar.bar, layout.tick_step);
  return layout;
}

void draw_sidebar(Canvas& canvas, const Look& look, const Sidebar& sidebar, int left_px) {
  const auto left = static_cast<float>(left_px);
  const Box margin{left, 0.0F, static_cast<float>(canvas.width_px()) - left, static_cast<float>(canvas.height_px())};
  if (margin.width <= 0.0F) return;
  canvas.rectangle(margin, look.page);
  const SidebarLayout layout = lay_out(sidebar, look, margin);
  const float h = layout.text_px;
  TextStyle style = look.text(kSidebarText);
  style.halo_alpha = 0.0F;
  for (const SidebarLayout::Row& row : layout.rows) {
    draw_sample(canvas, row.swatch, row.entry);
    for (std::size_t i = 0; i < row.lines.size(); ++i) {
      canvas.text({layout.text_left_px, row.first_baseline_px + static_cast<float>(i) * layout.line_px}, row.lines[i],
                  style);
    }
  }
  if (layout.left_out > 0) {
    canvas.text({layout.text_left_px, layout.left_out_baseline_px}, fmt::format("and {} more", layout.left_out), style);
  }
  if (!sidebar.bar) return;

  const ColorBar& bar = *sidebar.bar;
  canvas.text({layout.bar.left, layout.unit_baseline_px}, bar.unit, style);
  const int steps = std::clamp(static_cast<int>(layout.bar.height), 16, 128);
  const float step_px = layout.bar.height / static_cast<float>(steps);
  for (int i = 0; i < steps; ++i) {  // steps overlap slightly, which hides seams
    const float s = 1.0F - (static_cast<float>(i) + 0.5F) / static_cast<float>(steps);
    const float step_top = layout.bar.top + static_cast<float>(i) * step_px;
    canvas.rectangle(
        {layout.bar.left, step_top, layout.bar.width, std::min(step_px + 0.5F, layout.bar.bottom() - step_top)},
        bar.color(s));
  }
  for (const double tick : layout.ticks) {
    const double s = (tick - bar.low) / (bar.high - bar.low);
    const float y = layout.bar.top + static_cast<float>(1.0 - s) * layout.bar.height;
    const float thick = std::max(1.0F, 0.09F * h);
    canvas.rectangle({layout.bar.right(), y - 0.5F * thick, 0.5F * h, thick}, look.ink);
    canvas.text({layout.bar.right() + kTickLeft * h, y + 0.5F * h}, tick_text(tick, layout.tick_step), style);
  }
}

double depth_scale_end_m(const DepthImage& depth) {
  std::vector<float> seen;
  for (const float d : depth.depth_m) {
    if (d > 0.0F) seen.push_back(d);
  }
  if (seen.empty()) return 10.0;
  const auto nth = seen.begin() + static_cast<std::ptrdiff_t>(0.92 * static_cast<double>(seen.size() - 1));
  std::nth_element(seen.begin(), nth, seen.end());
  const double step = round_down_nicely(std::max(0.5, static_cast<double>(*nth)) / 4.0);
  return step * std::ceil(*nth / step);
}

Image depth_colors(const DepthImage& depth, double max_range_m, const Rgb& nothing) {
  Image image(depth.width, depth.height);
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      const float d = depth.at(x, y);
      set_pixel(image, x, y, d > 0.0F ? turbo_like(d / static_cast<float>(max_range_m)) : nothing);
    }
  }
  return image;
}

}  // namespace swiftlet::sim
