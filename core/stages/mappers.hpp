// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "core/mapping/mapper.hpp"
#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/config.hpp"

namespace swiftlet {

/// One row of core/stages/mappers.cpp.
struct MapperType {
  ModuleType module;
  std::unique_ptr<Mapper> (*make)(const ModuleConfig& config, const AgentSetup& setup);
};

std::span<const MapperType> mapper_types();
std::span<const ModuleType> mapper_module_types();
/// Null for `none`. Throws std::invalid_argument on an unknown type.
std::unique_ptr<Mapper> make_mapper(const Module& config, const AgentSetup& setup);

}  // namespace swiftlet
