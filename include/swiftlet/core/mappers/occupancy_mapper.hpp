// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/mappers/mapper.hpp"

namespace swiftlet {

/// Occupied, free and unknown cells around the vehicle, from its own LiDARs [Pritzl 2024, sec. III], or from the rays
/// of another vehicle that is localized in the same world.
struct OccupancyMapperConfig : ModuleConfigOf<OccupancyMapperConfig> {
  int every_column = 4;
  double range_min_m = 0.6;
  double clear_range_m = 8.0;
  double tracked_radius_m = 1.0;
  std::string rays_of;
  std::string send_rays_to;
  OccupancyMapConfig map;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Mapper> make_occupancy_mapper(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
