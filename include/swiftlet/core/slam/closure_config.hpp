// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet {

struct ClosureConfig {
  double window_xy_m = 3.0;     ///< [m] largest horizontal distance of a match from the estimate
  double window_z_m = 1.0;      ///< [m] largest vertical distance of a match from the estimate
  double window_yaw_deg = 8.0;  ///< [deg] largest heading difference of a match from the estimate
  double cell_m = 0.5;
  int levels = 4;
  int points = 400;
  double range_max_m = 25.0;
  int budget = 200000;
  double histogram_min = 0.6;     ///< [-] headings whose rotational histograms agree less are not searched
  double score_min = 0.5;         ///< [-] share of the points that must lie in occupied cells
  double rival_share = 0.9;       ///< [-] rejects a closure when another place reaches this share of the best score
  double rival_distance_m = 1.5;  ///< [m] least distance at which a match counts as another place
  double overlap_min = 0.4;       ///< [-] least share of the newer submap that the older one contains
  double near_min = 0.7;          ///< [-] least share of the overlapping points that lie on the older submap's surfaces

  void visit(ConfigVisitor& v);
};

/// Defaults of find_in_map: any heading, and stricter checks than around an estimate.
ClosureConfig global_closure_config();

/// Defaults for relocalization from few scans: parts of the map may lack some of the observed surroundings.
ClosureConfig locating_config();

}  // namespace swiftlet
