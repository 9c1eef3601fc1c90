// SPDX-License-Identifier: BSD-3-Clause
#include "core/stages/mappers.hpp"

#include "core/mapping/sparse_mapper.hpp"
#include "swiftlet/core/registry.hpp"

namespace swiftlet {
namespace {

struct NoMapperConfig : ModuleConfigOf<NoMapperConfig> {
  void visit(ConfigVisitor&) override {}
};

std::unique_ptr<Mapper> make_no_mapper(const ModuleConfig&, const AgentSetup&) { return nullptr; }

constexpr MapperType kMapperTypes[] = {
    {{"none", "no map of what is around", make_module_config<NoMapperConfig>}, make_no_mapper},
    {{"sparse", "voxels that the own LiDARs hit, near the vehicle [Kamler 2025, sec. 3.2]",
      make_module_config<SparseMapperConfig>},
     make_sparse_mapper},
};

}  // namespace

std::span<const MapperType> mapper_types() { return kMapperTypes; }

std::span<const ModuleType> mapper_module_types() { return module_types_of<kMapperTypes>(); }

std::unique_ptr<Mapper> make_mapper(const Module& config, const AgentSetup& setup) {
  return row_named(kMapperTypes, config.type, "mapping").make(*config.config, setup);
}

}  // namespace swiftlet
