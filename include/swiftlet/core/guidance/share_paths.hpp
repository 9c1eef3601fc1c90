// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// Vehicles that tell each other by radio where they will be, to compare the rule-based Lloyd algorithm with. Each
/// plans for itself, when it likes. A plan ends at rest and keeps clear of all paths that were heard. It is told, and
/// flown unless another one is heard meanwhile that it comes too near to (the delay check of Kondo et al., 2023).
/// Plans are the governor's own ways to places around the vehicle.
struct SharePathsConfig : ModuleConfigOf<SharePathsConfig> {
  Eigen::Vector3d goal_m = {0.0, 0.0, 2.0};
  double arrival_radius_m = 0.2;
  double speed_mps = 4.0;
  double encumbrance_m = 0.5;
  double margin_m = 0.1;
  double vertical_m = 1.5;
  double period_s = 0.5;
  double check_s = 0.2;
  double longest_s = 6.0;
  double z_min_m = 1.0;
  double z_max_m = 10.0;
  bool planar = false;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_share_paths(const ModuleConfig& config, const GuidanceSetup& setup);

/// Where somebody will be; before its beginning and after its end at rest.
struct PathInTime {
  TimeNs t = 0;
  double interval_s = 0.1;
  std::vector<Vector3> places_local_m;  ///< at least one

  Vector3 at_local_m(TimeNs now) const;
  TimeNs end() const { return t + from_seconds(interval_s * static_cast<double>(places_local_m.size() - 1)); }
};

/// The least distance of two from a time on. Heights count `distance_m / vertical_m` times.
double least_distance_m(const PathInTime& a, const PathInTime& b, TimeNs from, double distance_m, double vertical_m);

}  // namespace swiftlet
