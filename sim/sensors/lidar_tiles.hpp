// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "swiftlet/sim/raycast/sweep_scene.hpp"
#include "swiftlet/sim/sensors/lidar_pattern.hpp"

namespace swiftlet::sim {

/// 16 neighboring beams that are traced together.
struct LidarTile {
  BeamPacket beams;
  std::array<std::int32_t, kPacketSize> beam;  ///< index in the BeamTable; -1: unused lane
  bool meets_self = false;
};

/// Number of a beam's direction cell, about 5 deg wide; cells with consecutive numbers are neighbors.
/// Any frame, the same for all arguments.
int direction_cell(const Eigen::Vector3f& direction);

/// Groups the beams of a sweep by direction: blocks of the image where rows and columns form one, otherwise cells of
/// direction. Tracing 16 rays with similar directions costs half as much as 16 in firing order.
class LidarTiler {
 public:
  LidarTiler() = default;
  /// @param one_firing_a_column  false: every beam is a firing of its own
  LidarTiler(const LidarPattern& pattern, const BeamTable& beams, bool one_firing_a_column);

  /// Sets `beam` of every tile; allocates only in the first call.
  void arrange(const BeamTable& beams, std::vector<LidarTile>& tiles);
  /// Sets `beams` of a tile from its `beam`.
  void load(const BeamTable& beams, LidarTile& tile) const;

 private:
  void arrange_scattered(const BeamTable& beams);

  std::vector<std::int32_t> order_;  // beams in order of tracing, -1 in unused lanes
  std::vector<std::int32_t> cell_;   // (beams), only for scattered patterns
  std::vector<std::int32_t> first_;  // (cells + 1)
  bool is_image_ = true;
  bool one_firing_a_column_ = true;
};

}  // namespace swiftlet::sim
