// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/localization/relative_filter.hpp"

namespace swiftlet {

/// Vehicles with retro-reflective markers, straight from the returns of a scan. No free air around them is asked for.
/// So they are seen in a doorway, too, where a detector takes them for parts of the wall.
class MarkerSightings {
 public:
  /// @param reflectivity  that a return of a marker has at least
  /// @param radius_m      around the middle of a vehicle, in which all returns are taken for its own
  MarkerSightings(double reflectivity, double radius_m, double sigma_m)
      : reflectivity_(static_cast<float>(reflectivity)), radius_m_(static_cast<float>(radius_m)), sigma_m_(sigma_m) {}

  /// Middles of the boxes around what each vehicle shows, as of the instants at which it was hit.
  void append(const LocalCloud& cloud, std::vector<Sighting>& found);

 private:
  struct Body {
    Eigen::Vector3f middle_local_m;
    int count = 0;  // bright returns
  };
  void gather(const LocalCloud& cloud);
  bool center_on_returns(const LocalCloud& cloud, Body& body, TimeNs& t) const;

  float reflectivity_, radius_m_;
  double sigma_m_;
  std::vector<Body> bodies_;  // in this scan
};

}  // namespace swiftlet
