// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/control/motion_limits.hpp"
#include "swiftlet/core/guidance/neighbor_source.hpp"

namespace swiftlet {

/// Distances and limits by which a vehicle keeps apart from its neighbors (NeighborSafety).
struct SeparationConfig {
  bool enabled = true;
  double margin_m = 0.1;
  double sigmas = 2.0;
  double vertical_m = 1.5;
  /// [-] share of the room to a neighbor that may be used until its next sample; equal for all vehicles, below 0.5;
  /// smaller values slow vehicles down near each other; 0: no pledges
  double pledge_share = 0.45;
  double acceleration_mps2 = 2.5;
  double jerk_mps3 = 15.0;

  /// Horizontal distance to keep between the centers of two vehicles.
  double distance_m(double encumbrance_m) const { return 2.0 * encumbrance_m + margin_m; }
  /// Motion limits reduced to acceleration_mps2 and jerk_mps3, which the controller tracks closely; vertical limits in
  /// the same ratio.
  MotionLimits within(MotionLimits limits) const;
  void visit(ConfigVisitor& v);
};

/// Separation of a guidance other than `rbl`: the vehicle's own goals are admitted, moved or held back (kept_apart()).
struct KeepApartConfig : SeparationConfig {
  double encumbrance_m = 0.5;
  double z_min_m = 1.0;
  double z_max_m = 10.0;
  NeighborSourceConfig neighbors;

  KeepApartConfig() { enabled = false; }
  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet
