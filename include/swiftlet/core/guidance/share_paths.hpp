// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// Vehicles that broadcast their planned paths by radio, as a baseline for the rule-based Lloyd algorithm. Each plans
/// asynchronously. A plan ends at rest and keeps clear of all received paths. It is broadcast, and flown unless a
/// conflicting path is received during the delay check [Kondo et al., 2023]. Candidate plans are trajectories of the
/// reference governor to points around the vehicle.
struct SharePathsConfig : ModuleConfigOf<SharePathsConfig> {
  Eigen::Vector3d goal_m = {0.0, 0.0, 2.0};
  double arrival_radius_m = 0.2;
  double speed_mps = 4.0;
  double encumbrance_m = 0.5;
  double margin_m = 0.1;
  double vertical_m = 1.5;
  double period_s = 0.5;  ///< [s] period of planning; smaller values replan sooner and send more messages
  double check_s = 0.2;
  double z_min_m = 1.0;
  double z_max_m = 10.0;
  bool planar = false;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_share_paths(const ModuleConfig& config, const GuidanceSetup& setup);

/// Predicted path of a vehicle; at rest before its beginning and after its end.
struct PathInTime {
  TimeNs t = 0;
  double interval_s = 0.1;
  std::vector<Vector3> places_local_m;  ///< [m] positions every interval_s from t on; at least one

  Vector3 at_local_m(TimeNs now) const;
  TimeNs end() const { return t + from_seconds(interval_s * static_cast<double>(places_local_m.size() - 1)); }
};

/// Smallest distance [m] between two paths from a time on. Heights are scaled by `distance_m / vertical_m`, so that a
/// vertical separation of vertical_m counts as distance_m: downwash needs more room.
double least_distance_m(const PathInTime& a, const PathInTime& b, TimeNs from, double distance_m, double vertical_m);

}  // namespace swiftlet
