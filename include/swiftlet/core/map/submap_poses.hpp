// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "swiftlet/core/frames.hpp"
#include "swiftlet/core/map/submap_cells.hpp"

namespace swiftlet {

/// Where the submaps of a pose graph lie in the local frame, as far as the estimator knows by now. The surroundings
/// of the vehicle stand still there, and with them the submap that still grows. When the graph moves, older submaps
/// move. This happens at once, because the vehicle's pose in the local frame is right at once. Only what the vehicle
/// tells of the world follows little by little.
struct SubmapPoses {
  /// A submap is dropped when it is finished and older ones know what it saw. The next submap has the same number.
  struct Dropped {
    std::uint64_t count = 0;  ///< dropped submaps so far; all other fields are about the last one
    int submap = 0;           ///< number
    int into = 0;             ///< number of the older submap to which its cells belong from now on
    Pose T_into_submap = Pose::Identity();
  };

  std::uint64_t revision = 0;     ///< grows whenever a pose changes or a submap begins
  std::vector<Pose> T_local_own;  ///< by number, in the order in which they began; the last one grows
  Dropped dropped;
  std::size_t num_given = 0;        ///< submaps of an earlier flight's map
  std::vector<Pose> T_local_given;  ///< of these; none until it is known where they lie
  std::vector<MapPiece> given;      ///< what was seen of these; none until then, and the same from then on
};

}  // namespace swiftlet
