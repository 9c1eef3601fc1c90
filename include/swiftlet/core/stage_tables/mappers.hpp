// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/core/mappers/mapper.hpp"

namespace swiftlet {

/// Mapper type that a scenario can choose; the list is in core/stage_tables/mappers.cpp.
struct MapperType {
  ModuleType module;
  std::unique_ptr<Mapper> (*make)(const ModuleConfig& config, const AgentSetup& setup);
  /// Adds the sensors, truth and memory that the stage requires; null: none.
  void (*add_needs)(const ModuleConfig& config, AgentNeeds& needs) = nullptr;
  const char* overlays = nullptr;  ///< names of the overlays, separated by spaces; null: not declared
};

Registry<MapperType>& mapper_registry();
inline std::span<const ModuleType> mapper_module_types() { return mapper_registry().modules(); }
/// Null for `none`. Throws std::invalid_argument on an unknown type.
std::unique_ptr<Mapper> make_mapper(const Module& config, const AgentSetup& setup);

}  // namespace swiftlet
