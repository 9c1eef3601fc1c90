// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "sim/world/scene.hpp"
#include "swiftlet/core/config.hpp"

namespace swiftlet::sim {

/// One row of sim/registry/worlds.cpp: a generator is a pure function of (config, seed).
struct WorldType {
  ModuleType module;
  Scene (*make)(const ModuleConfig& config, std::uint64_t seed);
};

std::span<const WorldType> world_types();
std::span<const ModuleType> world_module_types();
Scene make_world(const Module& config, std::uint64_t seed);

}  // namespace swiftlet::sim
