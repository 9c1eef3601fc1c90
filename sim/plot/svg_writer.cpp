// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/plot/svg_writer.hpp"

#include <algorithm>
#include <cmath>

#include "sim/plot/ticks.hpp"
#include "swiftlet/sim/io/base64.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim::plot {
namespace {

std::string px(double value) { return number_text(value, 1); }

// Keeps the first, the extremes and the last of the points [begin, end), which lie in one pixel column.
void keep_column(const std::vector<PointPx>& points, std::size_t begin, std::size_t end, std::vector<PointPx>& out) {
  if (end - begin <= 4) {
    out.insert(out.end(), points.begin() + static_cast<std::ptrdiff_t>(begin),
               points.begin() + static_cast<std::ptrdiff_t>(end));
    return;
  }
  const auto first = points.begin() + static_cast<std::ptrdiff_t>(begin),
             last = points.begin() + static_cast<std::ptrdiff_t>(end);
  const auto [low, high] =
      std::minmax_element(first, last, [](const PointPx& a, const PointPx& b) { return a.y < b.y; });
  out.push_back(*first);
  out.push_back(*std::min(low, high));
  out.push_back(*std::max(low, high));
  out.push_back(*(last - 1));
}

std::vector<PointPx> thinned(const std::vector<PointPx>& points) {
  std::vector<PointPx> out;
  for (std::size_t begin = 0; begin < points.size();) {
    std::size_t end = begin + 1;
    while (end < points.size() && std::floor(points[end].x) == std::floor(points[begin].x)) ++end;
    keep_column(points, begin, end, out);
    begin = end;
  }
  return out;
}

std::string coordinates(const std::vector<PointPx>& points) {
  std::string text, previous;
  for (const PointPx& point : points) {
    std::string here = px(point.x) + "," + px(point.y);
    if (here == previous) continue;
    if (!text.empty()) text += ' ';
    text += here;
    previous = std::move(here);
  }
  return text;
}

}  // namespace

SvgWriter::SvgWriter(double width_px, double height_px, std::string_view title, double width_mm) {
  const std::string size = px(width_px) + " " + px(height_px);
  const auto length = [&](double of_px) {
    return width_mm > 0.0 ? number_text(of_px * width_mm / width_px, 3) + "mm" : px(of_px);
  };
  out_ = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + length(width_px) + "\" height=\"" + length(height_px) +
         "\" viewBox=\"0 0 " + size + "\" font-family=\"DejaVu Sans, Verdana, Arial, sans-serif\" role=\"img\">\n";
  if (!title.empty()) out_ += "<title>" + escape_markup(title) + "</title>\n";
  rect(0.0, 0.0, width_px, height_px, "fill=\"#fff\"");
}

void SvgWriter::rect(double x, double y, double width, double height, std::string_view attributes) {
  out_ += "<rect x=\"" + px(x) + "\" y=\"" + px(y) + "\" width=\"" + px(width) + "\" height=\"" + px(height) + "\" ";
  out_ += attributes;
  out_ += "/>\n";
}

void SvgWriter::segment(PointPx a, PointPx b, std::string_view attributes) {
  out_ += "<path d=\"M" + px(a.x) + "," + px(a.y) + "L" + px(b.x) + "," + px(b.y) + "\" ";
  out_ += attributes;
  out_ += "/>\n";
}

void SvgWriter::circle(PointPx center, double radius, std::string_view attributes) {
  out_ += "<circle cx=\"" + px(center.x) + "\" cy=\"" + px(center.y) + "\" r=\"" + px(radius) + "\" ";
  out_ += attributes;
  out_ += "/>\n";
}

void SvgWriter::polyline(const std::vector<PointPx>& points, std::string_view attributes) {
  if (points.empty()) return;
  out_ += "<polyline points=\"" + coordinates(thinned(points)) + "\" fill=\"none\" stroke-linejoin=\"round\" ";
  out_ += attributes;
  out_ += "/>\n";
}

void SvgWriter::polygon(const std::vector<PointPx>& points, std::string_view attributes) {
  if (points.empty()) return;
  out_ += "<polygon points=\"" + coordinates(points) + "\" ";
  out_ += attributes;
  out_ += "/>\n";
}

void SvgWriter::text(PointPx at, std::string_view content, double size_px, Anchor anchor, std::string_view color,
                     double turn_deg, bool bold) {
  if (content.empty()) return;
  begin_text(at, size_px);
  out_ += " fill=\"";
  out_ += color;
  out_ += "\"";
  add_anchor(anchor);
  if (bold) out_ += " font-weight=\"bold\"";
  if (turn_deg != 0.0) out_ += " transform=\"rotate(" + px(turn_deg) + " " + px(at.x) + " " + px(at.y) + ")\"";
  end_text(content);
}

void SvgWriter::text_with(PointPx at, std::string_view content, double size_px, Anchor anchor,
                          std::string_view attributes) {
  if (content.empty()) return;
  begin_text(at, size_px);
  add_anchor(anchor);
  out_ += ' ';
  out_ += attributes;
  end_text(content);
}

void SvgWriter::begin_text(PointPx at, double size_px) {
  out_ += "<text x=\"" + px(at.x) + "\" y=\"" + px(at.y) + "\" font-size=\"" + px(size_px) + "\"";
}

void SvgWriter::add_anchor(Anchor anchor) {
  if (anchor == Anchor::kMiddle) out_ += " text-anchor=\"middle\"";
  if (anchor == Anchor::kEnd) out_ += " text-anchor=\"end\"";
}

void SvgWriter::end_text(std::string_view content) {
  out_ += '>';
  out_ += escape_markup(content);
  out_ += "</text>\n";
}

void SvgWriter::picture(double x, double y, double width, double height, std::string_view png) {
  out_ += "<image x=\"" + px(x) + "\" y=\"" + px(y) + "\" width=\"" + px(width) + "\" height=\"" + px(height) +
          "\" preserveAspectRatio=\"none\" href=\"data:image/png;base64," + base64(png) + "\"/>\n";
}

void SvgWriter::begin_clip(double x, double y, double width, double height) {
  // Named after the rectangle, so that each name has one meaning on a page with many figures.
  const std::string id = "clip_" + px(x) + "_" + px(y) + "_" + px(width) + "_" + px(height);
  out_ += "<clipPath id=\"" + id + "\"><rect x=\"" + px(x) + "\" y=\"" + px(y) + "\" width=\"" + px(width) +
          "\" height=\"" + px(height) + "\"/></clipPath>\n<g clip-path=\"url(#" + id + ")\">\n";
}

void SvgWriter::end_clip() { out_ += "</g>\n"; }

std::string SvgWriter::finish() {
  out_ += "</svg>\n";
  return std::move(out_);
}

double text_width(std::string_view content, double size_px) {
  // Counts code points, not bytes.
  const auto count = std::count_if(content.begin(), content.end(),
                                   [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
  return 0.6 * size_px * static_cast<double>(count);
}

}  // namespace swiftlet::sim::plot
