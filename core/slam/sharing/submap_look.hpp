// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/slam/graph/branch_and_bound.hpp"

namespace swiftlet {

/// Descriptor of a submap: directions of its surfaces and heights of its upright structure. The heading of the submap
/// only shifts the directions. The cloud is in the frame of the submap (T_local_submap).
struct SubmapLook {
  /// [-] Bins of 1 m. More bins distinguish taller structure and enlarge messages.
  static constexpr std::size_t kHeights = 16;
  RotationalHistogram directions{std::span<const Eigen::Vector3f>{}};
  std::array<std::uint8_t, kHeights> heights{};

  /// None when the received data have another size.
  static std::optional<SubmapLook> from_quantized(std::span<const std::uint8_t> directions,
                                                  std::span<const std::uint8_t> heights);
};

/// Descriptor of a cloud whose frame has z up.
SubmapLook look_of(std::span<const Eigen::Vector3f> points_submap_m, double cell_m, double range_max_m);

/// Similarity at the best heading; 1 when the descriptors are equal.
double likeness(const SubmapLook& a, const SubmapLook& b);

}  // namespace swiftlet
