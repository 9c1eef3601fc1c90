// SPDX-License-Identifier: BSD-3-Clause
#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_GLYPH_H
#include FT_STROKER_H

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <string>

#include "embedded/sim_render.hpp"
#include "sim/render/image.hpp"

namespace swiftlet::sim {
namespace {

constexpr float kHaloWidth = 0.24F;  // extent of the halo beyond the letters, as a share of a capital's height

void check(FT_Error error, const char* what) {
  if (error != 0) throw std::runtime_error("cannot " + std::string(what) + ": FreeType error " + std::to_string(error));
}

/// The embedded font. FreeType must be called by one thread at a time.
struct Font {
  std::mutex mutex;
  FT_Library library = nullptr;
  FT_Face face = nullptr;
  FT_Stroker stroker = nullptr;

  Font() {
    check(FT_Init_FreeType(&library), "start FreeType");
    const std::string_view file = embedded::DejaVuSans_ttf;
    check(FT_New_Memory_Face(library, reinterpret_cast<const FT_Byte*>(file.data()), static_cast<FT_Long>(file.size()),
                             0, &face),
          "read the embedded font");
    check(FT_Stroker_New(library, &stroker), "make a stroker");
  }
  ~Font() {
    FT_Stroker_Done(stroker);
    FT_Done_FreeType(library);
  }
  Font(const Font&) = delete;
  Font& operator=(const Font&) = delete;

  /// Advance [em] from one letter to the next.
  float advance_em(char32_t letter) {
    check(FT_Load_Char(face, letter, FT_LOAD_NO_SCALE), "load a letter");
    return static_cast<float>(face->glyph->advance.x) / static_cast<float>(face->units_per_EM);
  }
};

Font& font() {
  static Font instance;
  return instance;
}

FT_F26Dot6 to_26_6(float px) { return std::lround(64.0F * px); }

/// Code points of UTF-8. A byte that does not begin one is taken as a code point.
std::u32string letters_of(std::string_view text) {
  std::u32string letters;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const int more = lead < 0xC0 ? 0 : lead < 0xE0 ? 1 : lead < 0xF0 ? 2 : 3;
    char32_t letter = more == 0 ? lead : lead & (0x3FU >> more);
    for (int k = 0; k < more && i + 1 < text.size() && (text[i + 1] & 0xC0) == 0x80; ++k)
      letter = letter << 6 | (static_cast<unsigned char>(text[++i]) & 0x3FU);
    letters.push_back(letter);
  }
  return letters;
}

/// Coverage of each pixel of a rectangle, 0..255.
struct Coverage {
  int left = 0, top = 0, width = 0, height = 0;
  std::vector<std::uint8_t> share;

  void add(FT_Glyph glyph, FT_Vector at) {
    check(FT_Glyph_To_Bitmap(&glyph, FT_RENDER_MODE_NORMAL, &at, true), "draw a letter");
    const auto* const bitmap = reinterpret_cast<FT_BitmapGlyph>(glyph);
    for (int row = 0; row < static_cast<int>(bitmap->bitmap.rows); ++row) {
      const int y = row - bitmap->top - top;
      if (y < 0 || y >= height) continue;
      for (int column = 0; column < static_cast<int>(bitmap->bitmap.width); ++column) {
        const int x = column + bitmap->left - left;
        if (x < 0 || x >= width) continue;
        std::uint8_t& covered = share[static_cast<std::size_t>(y) * width + x];
        covered = std::max(covered, bitmap->bitmap.buffer[row * bitmap->bitmap.pitch + column]);
      }
    }
    FT_Done_Glyph(glyph);
  }
};

}  // namespace

float text_width_px(std::string_view text, float height_px) {
  const std::lock_guard lock(font().mutex);
  float width_em = 0.0F;
  for (const char32_t letter : letters_of(text)) width_em += font().advance_em(letter);
  return width_em * height_px / kCapitalOfFont;
}

void draw_text(Image& image, float x, float y, std::string_view text, const TextStyle& style) {
  const float width = text_width_px(text, style.height_px);
  if (style.align == Align::kCenter) x -= 0.5F * width;
  if (style.align == Align::kRight) x -= width;

  const float size_px = style.height_px / kCapitalOfFont, halo_px = kHaloWidth * style.height_px;
  Coverage ink;
  ink.left = std::max(0, static_cast<int>(std::floor(x - size_px)));
  ink.top = std::max(0, static_cast<int>(std::floor(y - 1.5F * size_px)));
  ink.width = std::min(image.width, static_cast<int>(std::ceil(x + width + size_px))) - ink.left;
  ink.height = std::min(image.height, static_cast<int>(std::ceil(y + size_px))) - ink.top;
  if (ink.width <= 0 || ink.height <= 0) return;
  ink.share.assign(static_cast<std::size_t>(ink.width) * ink.height, 0);
  Coverage halo = ink;

  const std::lock_guard lock(font().mutex);
  const FT_Face face = font().face;
  check(FT_Set_Char_Size(face, 0, to_26_6(size_px), 72, 72),
        "scale the font");  // at 72 dpi a point is a pixel
  FT_Stroker_Set(font().stroker, to_26_6(halo_px), FT_STROKER_LINECAP_ROUND, FT_STROKER_LINEJOIN_ROUND, 0);
  for (const char32_t letter : letters_of(text)) {
    check(FT_Load_Char(face, letter, FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP), "load a letter");
    FT_Glyph filled = nullptr, stroked = nullptr;
    check(FT_Get_Glyph(face->glyph, &filled), "load a letter");
    check(FT_Glyph_Copy(filled, &stroked), "load a letter");
    check(FT_Glyph_Stroke(&stroked, font().stroker, true), "draw the halo of a letter");
    const FT_Vector at{to_26_6(x), to_26_6(-y)};
    halo.add(stroked, at);
    ink.add(filled, at);
    x += font().advance_em(letter) * size_px;
  }
  for (int row = 0; row < ink.height; ++row) {
    for (int column = 0; column < ink.width; ++column) {
      const std::size_t i = static_cast<std::size_t>(row) * ink.width + column;
      if (halo.share[i] == 0 && ink.share[i] == 0) continue;
      blend_pixel(image, ink.left + column, ink.top + row, style.halo,
                  style.halo_alpha * static_cast<float>(halo.share[i]) / 255.0F);
      blend_pixel(image, ink.left + column, ink.top + row, style.color, static_cast<float>(ink.share[i]) / 255.0F);
    }
  }
}

}  // namespace swiftlet::sim
