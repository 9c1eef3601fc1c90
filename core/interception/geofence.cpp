// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/geofence.hpp"

#include <algorithm>

namespace swiftlet {

void GeofenceConfig::visit(ConfigVisitor& v) {
  v.field("min_m", min_m,
          "[m] corner of smallest coordinates, world frame; the height keeps vehicle and net off the ground");
  v.field("max_m", max_m, "[m] corner of largest coordinates, world frame");
  v.field("patience_s", patience_s, "[s] time outside the fence after which a target is abandoned",
          Range::non_negative());
  v.check((max_m.array() > min_m.array()).all(), "max_m", "more than min_m in each direction");
}

Geofence::Geofence(const GeofenceConfig& config, const FrameChange& to_local) {
  std::size_t i = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sense : {-1.0, 1.0}) {
      const Vector3 normal = to_local.direction(sense * Vector3::Unit(axis));
      sides_[i++] = {normal, normal.dot(to_local.point(sense < 0.0 ? config.min_m : config.max_m))};
    }
  }
}

double Geofence::excess_m(const Vector3& p_local_m) const {
  double greatest_m = sides_[0].excess_m(p_local_m);
  for (const Wall& side : sides_) greatest_m = std::max(greatest_m, side.excess_m(p_local_m));
  return greatest_m;
}

Vector3 Geofence::inside(Vector3 p_local_m) const {
  for (const Wall& side : sides_) p_local_m -= std::max(side.excess_m(p_local_m), 0.0) * side.normal;
  return p_local_m;
}

}  // namespace swiftlet
