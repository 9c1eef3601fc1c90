// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet {

/// Field of view of a LiDAR around its x axis, for drivers that report no directions of shots without return
/// (BeamTable::directions_lidar). Both elevations 0: learned from the returns.
struct FieldOfView {
  double bottom_deg = 0.0;
  double top_deg = 0.0;
  double width_deg = 360.0;

  void visit(ConfigVisitor& v);
  bool is_learned() const { return bottom_deg == 0.0 && top_deg == 0.0; }
};

}  // namespace swiftlet
