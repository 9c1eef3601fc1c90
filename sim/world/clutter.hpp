// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "sim/world/scene_builder.hpp"
#include "swiftlet/sim/world/clutter_config.hpp"

namespace swiftlet::sim {

/// Radius of the largest thing at its usual scale.
inline constexpr double kClutterReach_m = 0.5;

/// Ground of a world for its clutter. A random thing without a free place after some draws is left out.
struct ClutterGround {
  std::function<double(const Eigen::Vector2d& p_world_m)> height_m;
  std::function<bool(const Eigen::Vector2d& p_world_m)> is_free;
};

void add_clutter(SceneBuilder& scene, const ClutterConfig& config, std::uint64_t seed, const ClutterGround& ground);

}  // namespace swiftlet::sim
