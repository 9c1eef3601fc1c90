// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// World generator that a scenario can choose, a pure function of (config, seed); the list is in
/// sim/registry/worlds.cpp.
struct WorldType {
  ModuleType module;
  Scene (*make)(const ModuleConfig& config, std::uint64_t seed);
};

Registry<WorldType>& world_registry();
inline std::span<const ModuleType> world_module_types() { return world_registry().modules(); }
Scene make_world(const Module& config, std::uint64_t seed);

}  // namespace swiftlet::sim
