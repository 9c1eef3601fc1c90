// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "sim/render/mark_painter.hpp"
#include "sim/render/picture_scene.hpp"
#include "sim/render/picture_style.hpp"

/// Overlays and trails of a picture, drawn by a MarkPainter. The caller sets blending and depth test.
namespace swiftlet::sim {

bool is_opaque(const Overlay& overlay);
void draw_overlay(const GlFunctions& gl, MarkPainter& marks, const View& view, const Overlay& overlay,
                  const PictureStyle& style);
/// Appends the trails of all vehicles as ribbons that fade with age, and their outlines.
void append_trails(const View& view, const PictureScene& picture, float line_scale, std::vector<ClipVertex>& outline,
                   std::vector<ClipVertex>& ribbon);

}  // namespace swiftlet::sim
