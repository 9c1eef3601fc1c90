// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/map/sparse_voxel_map.hpp"
#include "swiftlet/core/mappers/mapper.hpp"

namespace swiftlet {

/// Voxels near the vehicle that its own LiDARs hit.
struct SparseMapperConfig : ModuleConfigOf<SparseMapperConfig> {
  double range_min_m = 0.6;
  double range_max_m = 40.0;
  double tracked_radius_m = 1.0;
  SparseVoxelMapConfig map;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Mapper> make_sparse_mapper(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
