// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace swiftlet::sim {

inline constexpr float kFontCapHeight = 9.0F;  ///< height of a capital above the baseline [font units]
inline constexpr float kFontGap = 2.6F;        ///< between two letters [font units]

using Stroke = std::vector<Eigen::Vector2f>;  ///< polyline; x right, y up, baseline at y = 0

/// Strokes of a printable ASCII character; anything else is a box. Thread-safe.
const std::vector<Stroke>& font_strokes(char c);
/// Distance from this letter's left edge to the next one's [font units].
float font_advance(char c);

}  // namespace swiftlet::sim
