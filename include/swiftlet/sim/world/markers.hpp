// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// Retro-reflective sleeves on a vehicle, detectable by the LiDAR of another vehicle [Pritzl 2024, sec. II-B].
struct MarkersConfig {
  enum class Place { kNone, kLegs };
  Place place = Place::kNone;
  double length_m = 0.08;
  double width_m = 0.03;
  double reflectivity = 0.9;

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
