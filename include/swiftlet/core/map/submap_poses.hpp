// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/map/submap_cells.hpp"

namespace swiftlet {

/// Poses of the submaps of a pose graph in the local frame, as estimated by now. The vehicle's surroundings stay fixed
/// in it, and so does the growing submap. When the graph changes, older submaps move at once, because the vehicle's
/// pose in the local frame is continuous. Only the correction to the world is blended gradually.
struct SubmapPoses {
  /// A finished submap is dropped when older submaps cover its observations. The next submap gets its number.
  struct Dropped {
    std::uint64_t count = 0;  ///< number of dropped submaps so far; the other fields refer to the last one
    int submap = 0;           ///< number
    int into = 0;             ///< number of the older submap that takes over its cells
    Pose T_into_submap = Pose::Identity();
  };

  std::uint64_t revision = 0;     ///< increases when a pose changes or a submap begins
  std::vector<Pose> T_local_own;  ///< indexed by number, in the order of their beginning; the last one grows
  Dropped dropped;
  std::size_t num_given = 0;        ///< number of submaps of the prior map
  std::vector<Pose> T_local_given;  ///< poses of these; empty before relocalization
  std::vector<MapPiece> given;      ///< cells of these; empty before relocalization, constant afterwards
};

}  // namespace swiftlet
