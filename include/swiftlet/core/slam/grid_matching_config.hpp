// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet {

struct AdaptiveVoxelConfig {
  double edge_max_m = 2.0;    ///< [m] largest edge of the cubes that keep one point each
  int points_min = 150;       ///< [-] the edge shrinks until at least this many points are left
  double range_max_m = 15.0;  ///< [m] points farther away are ignored; larger values match more points
};

struct GridMatchConfig {
  double high_weight = 1.0;             ///< [-] weight of occupied space in the finer grid
  double low_weight = 6.0;              ///< [-] weight of occupied space in the coarser grid
  double translation_weight_1_m = 5.0;  ///< [1/m] weight of the displacement from the prediction
  double rotation_weight = 400.0;       ///< [-] weight of half the angle from the prediction
  int iterations = 12;  ///< [-] largest number of iterations of the least squares; larger values cost time
};

struct GridSubmapConfig {
  double high_resolution_m = 0.1;  ///< [m] edge of a cell of the finer grid
  double low_resolution_m = 0.45;  ///< [m] edge of a cell of the coarser grid
  double high_range_max_m = 20.0;  ///< [m] points farther away do not go into the finer grid
  int scans = 160;
  double hit_probability = 0.55;   ///< [-] probability of a surface in a cell with a return
  double miss_probability = 0.49;  ///< [-] probability of a surface in a cell before a return
  int cells_missed = 2;            ///< [-] cells before a return that count as free

  void visit(ConfigVisitor& v);
};

struct GridMatchingConfig {
  double range_min_m = 1.0;
  double range_max_m = 60.0;
  double voxel_m = 0.15;                     ///< [m] one return in a cube of this edge goes into the map
  AdaptiveVoxelConfig high{2.0, 150, 15.0};  ///< points that are matched to the finer grid
  AdaptiveVoxelConfig low{4.0, 200, 60.0};   ///< points that are matched to the coarser grid
  GridMatchConfig cost;
  GridSubmapConfig submaps;
  double insert_after_m = 0.1;     ///< [m] motion after which a scan goes into the map
  double insert_after_deg = 0.23;  ///< [deg] rotation after which a scan goes into the map
  double insert_after_s = 0.5;     ///< [s] time after which a scan goes into the map without motion
  double points_per_error = 4.0;   ///< [-] points assumed to share one error, for the covariance

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet
