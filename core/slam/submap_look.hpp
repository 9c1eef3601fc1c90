// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "swiftlet/core/slam/branch_and_bound.hpp"

namespace swiftlet {

/// What a submap looks like from afar: directions of its surfaces, and how high stands what is upright. Its heading
/// changes neither but by a shift of the directions. Its cloud is in the frame that T_local_submap tells.
struct SubmapLook {
  static constexpr std::size_t kHeights = 16;  // of a meter
  RotationalHistogram directions{std::span<const Eigen::Vector3f>{}};
  std::array<std::uint8_t, kHeights> heights{};

  /// None when a vehicle tells something else.
  static std::optional<SubmapLook> of_told(std::span<const std::uint8_t> directions,
                                           std::span<const std::uint8_t> heights);
};

/// Of a cloud whose frame has z up.
SubmapLook look_of(std::span<const Eigen::Vector3f> points_submap_m, double cell_m, double range_max_m);

/// 1 when two look the same at the best heading.
double likeness(const SubmapLook& a, const SubmapLook& b);

}  // namespace swiftlet
