// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/map/submap_map.hpp"
#include "swiftlet/core/mappers/mapper.hpp"

namespace swiftlet {

/// Map made of the submaps of the localization's pose graph [Orsulic 2021, sec. IV]. Each submap has the cells observed
/// occupied and free by its scans. When the graph changes, the map moves with its submaps.
struct SubmapMapperConfig : ModuleConfigOf<SubmapMapperConfig> {
  int every_column = 4;
  double range_min_m = 0.6;
  double range_max_m = 20.0;
  double clear_range_m = 8.0;
  double tracked_radius_m = 1.0;
  double edge_m = 0.2;
  double p_miss = 0.4;
  double p_occupied = 0.7;
  int outvoted_by = 2;
  double covered_share = 0.9;
  int pieces_max = 300;

  void visit(ConfigVisitor& v) override;
  OccupancyMapConfig growing() const;
  SubmapMapConfig whole() const;
  /// Estimated memory: pieces_max pieces, a quarter of the reachable volume of each observed.
  double bytes() const;
};

std::unique_ptr<Mapper> make_submap_mapper(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
