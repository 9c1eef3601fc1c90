// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/stage_tables/mappers.hpp"

#include "swiftlet/core/mappers/occupancy_mapper.hpp"
#include "swiftlet/core/mappers/submap_mapper.hpp"

namespace swiftlet {
namespace {

struct NoMapperConfig : ModuleConfigOf<NoMapperConfig> {
  void visit(ConfigVisitor&) override {}
};

std::unique_ptr<Mapper> make_no_mapper(const ModuleConfig&, const AgentSetup&) { return nullptr; }

void need_for_occupancy(const ModuleConfig& config, AgentNeeds& needs) {
  needs.memory.push_back({"mapping.keep_radius_m", dynamic_cast<const OccupancyMapperConfig&>(config).map.bytes()});
}

void need_for_submaps(const ModuleConfig& config, AgentNeeds& needs) {
  needs.memory.push_back({"mapping.pieces_max", dynamic_cast<const SubmapMapperConfig&>(config).bytes()});
}

constexpr MapperType kMapperTypes[] = {
    {{"none", "no map of the surroundings", make_module_config<NoMapperConfig>}, make_no_mapper, nullptr, ""},
    {{"occupancy", "occupied, free and unknown cells, as OctoMap has them [Hornung 2013]",
      make_module_config<OccupancyMapperConfig>},
     make_occupancy_mapper,
     need_for_occupancy,
     "mapping.cells"},
    {{"submaps", "cells attached to the submaps of SLAM's pose graph, which move with the submaps [Orsulic 2021]",
      make_module_config<SubmapMapperConfig>},
     make_submap_mapper,
     need_for_submaps,
     "mapping.cells mapping.map"},
};

}  // namespace

Registry<MapperType>& mapper_registry() {
  static Registry<MapperType> table("mapping", kMapperTypes);
  return table;
}

std::unique_ptr<Mapper> make_mapper(const Module& config, const AgentSetup& setup) {
  return mapper_registry().make(config, setup);
}

}  // namespace swiftlet
