// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/localization/relative_filter.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"

namespace swiftlet {

/// Detects vehicles with retro-reflective markers in the returns of a scan. It needs no free air around them and so
/// finds them in a doorway, where a detector takes them for parts of the wall.
class MarkerSightings {
 public:
  /// @param reflectivity  least reflectivity of a return from a marker
  /// @param radius_m      all returns within this distance of a vehicle's center belong to it
  MarkerSightings(double reflectivity, double radius_m)
      : reflectivity_(static_cast<float>(reflectivity)), radius_m_(static_cast<float>(radius_m)) {}

  /// Appends the centers of the boxes around the visible part of each vehicle, stamped with the times of their returns.
  void append(const LocalCloud& cloud, std::vector<Sighting>& found);

 private:
  struct Body {
    Eigen::Vector3f middle_local_m;
    int count = 0;  // number of bright returns
  };
  void gather(const LocalCloud& cloud);
  bool center_on_returns(const LocalCloud& cloud, Body& body, TimeNs& t) const;

  float reflectivity_, radius_m_;
  std::vector<Body> bodies_;  // in this scan
};

}  // namespace swiftlet
