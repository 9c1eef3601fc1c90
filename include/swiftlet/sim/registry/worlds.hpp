// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// One row of sim/registry/worlds.cpp: a generator is a pure function of (config, seed).
struct WorldType {
  ModuleType module;
  Scene (*make)(const ModuleConfig& config, std::uint64_t seed);
};

Registry<WorldType>& world_registry();
inline std::span<const ModuleType> world_module_types() { return world_registry().modules(); }
Scene make_world(const Module& config, std::uint64_t seed);

}  // namespace swiftlet::sim
