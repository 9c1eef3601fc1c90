// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/world/clutter_config.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Empty space, or a flat ground plane at z = 0.
struct EmptyConfig : ModuleConfigOf<EmptyConfig> {
  bool ground = false;
  Eigen::Vector2d size_m = {100.0, 100.0};
  double reflectivity = 0.3;
  ClutterConfig clutter;

  void visit(ConfigVisitor& v) override;
};

Scene make_empty(const EmptyConfig& config, std::uint64_t seed);

}  // namespace swiftlet::sim
