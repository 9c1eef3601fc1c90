// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/stroke_font.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace swiftlet::sim {
namespace {

// A glyph is a list of strokes, each a list of points "xy": x a digit, y a hexadecimal digit, 3 being the baseline,
// 9 the height of "x" and c that of "X". '~' in front: a smooth open curve; 'o': a smooth closed one.
struct Glyph {
  char c;
  const char* strokes;
};

constexpr Glyph kGlyphs[] = {
    {'0', "o03535c0c"},
    {'1', "1a3c33"},
    {'2', "~0a0c5c5713 0353"},
    {'3', "~0b0c5c5828 ~2868630305"},
    {'4', "434c0656"},
    {'5', "5c0c08 ~082969630304"},
    {'6', "~5b5c0c03535909 0907"},
    {'7', "0c5c23"},
    {'8', "o08585c0c o03535808"},
    {'9', "~0403535c0c0656 5658"},
    {'A', "033c63 1656"},
    {'B', "030c 0c2c ~2c5c5828 0828 ~2868632303 "},
    {'C', "~6a6c0c036365"},
    {'D', "030c2c ~2c6c6323 2303"},
    {'E', "5c0c0353 0848"},
    {'F', "5c0c03 0848"},
    {'G', "~6a6c0c036367 6738"},
    {'H', "030c 535c 0858"},
    {'I', "030c"},
    {'J', "4c46 ~46430304"},
    {'K', "030c 075c 1853"},
    {'L', "0c0353"},
    {'M', "030c376c63"},
    {'N', "030c535c"},
    {'O', "o03636c0c"},
    {'P', "030c2c ~2c5c5727 2707"},
    {'Q', "o03636c0c 4562"},
    {'R', "030c2c ~2c5c5727 2707 2753"},
    {'S', "~5a5c0c0858530305"},
    {'T', "0c6c 3c33"},
    {'U', "0c06 ~06035356 565c"},
    {'V', "0c336c"},
    {'W', "0c234b638c"},
    {'X', "035c 0c53"},
    {'Y', "0c386c 3833"},
    {'Z', "0c5c0353"},
    {'a', "~08194947 4743 ~4606034344"},
    {'b', "0c03 o03434909"},
    {'c', "~484909034344"},
    {'d', "4c43 o03434909"},
    {'e', "0646 ~464909034344"},
    {'f', "~3c1c1a 1a13 0939"},
    {'g', "4942 ~42400001 o03434909"},
    {'h', "0c03 ~06094946 4643"},
    {'i', "0309 0b0c"},
    {'j', "2921 ~212000 2b2c"},
    {'k', "0c03 4905 1643"},
    {'l', "0c03"},
    {'m', "0903 ~06093936 3633 ~36396966 6663"},
    {'n', "0903 ~06094946 4643"},
    {'o', "o03434909"},
    {'p', "0900 o03434909"},
    {'q', "4940 o03434909"},
    {'r', "0903 ~06093938"},
    {'s', "~4849090646430304"},
    {'t', "1b15 ~151333 0939"},
    {'u', "0906 ~06034346 4943"},
    {'v', "092349"},
    {'w', "0923384369"},
    {'x', "0349 0943"},
    {'y', "0923 4910"},
    {'z', "09490343"},
    {' ', ""},
    {'.', "0303"},
    {',', "0402"},
    {':', "0404 0808"},
    {';', "0402 0808"},
    {'-', "0737"},
    {'_', "0252"},
    {'/', "014d"},
    {'\\', "0d41"},
    {'|', "010d"},
    {'(', "~2d0a0522"},
    {')', "~0d2a2502"},
    {'[', "2d0d0222"},
    {']', "0d2d2202"},
    {'{', "2d1d1807 071222"},
    {'}', "0d1d1827 271202"},
    {'<', "490743"},
    {'>', "094703"},
    {'+', "0747 2529"},
    {'=', "0545 0848"},
    {'*', "2b27 0a48 4a08"},
    {'%', "035c o0a2a2c0c o33535535"},
    {'#', "131c 434c 0656 0a5a"},
    {'&', "~5303072a3c1c1a53"},
    {'\'', "0c0a"},
    {'"', "0c0a 2c2a"},
    {'`', "0c2a"},
    {'^', "092c49"},
    {'~', "~0608284647"},
    {'!', "0c06 0303"},
    {'?', "~0a0c4c4826 2625 2323"},
    {'$', "~5a5b0b0858540405 3c33"},
    {'@', "o03636c0c o25454a2a"},
};
constexpr const char* kBox = "03434c0c03";

float units(char digit) { return static_cast<float>(digit <= '9' ? digit - '0' : digit - 'a' + 10); }

/// One round of Chaikin's corner cutting: converges to the quadratic B-spline of the points.
Stroke cut_corners(const Stroke& points, bool closed) {
  Stroke out;
  if (!closed) out.push_back(points.front());
  const std::size_t n = points.size();
  for (std::size_t i = 0; i + (closed ? 0 : 1) < n; ++i) {
    const Eigen::Vector2f& a = points[i];
    const Eigen::Vector2f& b = points[(i + 1) % n];
    out.push_back(0.75F * a + 0.25F * b);
    out.push_back(0.25F * a + 0.75F * b);
  }
  if (!closed) out.push_back(points.back());
  return out;
}

Stroke parse_stroke(std::string_view text) {
  const bool closed = text.front() == 'o';
  const bool smooth = closed || text.front() == '~';
  if (smooth) text.remove_prefix(1);
  Stroke points;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2) points.emplace_back(units(text[i]), units(text[i + 1]) - 3.0F);
  for (int round = 0; smooth && round < 3; ++round) points = cut_corners(points, closed);
  if (closed) points.push_back(points.front());
  return points;
}

struct ParsedGlyph {
  std::vector<Stroke> strokes;
  float width = 3.0F;
};

ParsedGlyph parse_glyph(std::string_view text) {
  ParsedGlyph glyph;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    if (end > 0) glyph.strokes.push_back(parse_stroke(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (!glyph.strokes.empty()) glyph.width = 0.0F;
  for (const Stroke& stroke : glyph.strokes) {
    for (const Eigen::Vector2f& p : stroke) glyph.width = std::max(glyph.width, p.x());
  }
  return glyph;
}

const ParsedGlyph& glyph_of(char c) {
  static const std::array<ParsedGlyph, 128> kTable = [] {
    std::array<ParsedGlyph, 128> table;
    table.fill(parse_glyph(kBox));
    for (const Glyph& glyph : kGlyphs) table[static_cast<std::size_t>(glyph.c)] = parse_glyph(glyph.strokes);
    // Figures have one width, so that a running clock does not tremble.
    for (char digit = '0'; digit <= '9'; ++digit) table[static_cast<std::size_t>(digit)].width = 5.0F;
    return table;
  }();
  const auto index = static_cast<unsigned char>(c);
  return kTable[index < 128 ? index : 127];
}

}  // namespace

const std::vector<Stroke>& font_strokes(char c) { return glyph_of(c).strokes; }

float font_advance(char c) { return glyph_of(c).width + kFontGap; }

}  // namespace swiftlet::sim
