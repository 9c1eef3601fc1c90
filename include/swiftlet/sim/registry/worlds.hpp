// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// World generator that a scenario selects by name. make() is a pure function of its arguments. The list is in
/// sim/registry/worlds.cpp.
struct WorldType {
  ModuleType module;
  Scene (*make)(const ModuleConfig& config, std::uint64_t seed);
};

Registry<WorldType>& world_registry();
inline std::span<const ModuleType> world_module_types() { return world_registry().modules(); }
Scene make_world(const Module& config, std::uint64_t seed);

}  // namespace swiftlet::sim
