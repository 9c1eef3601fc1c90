// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/guidance/neighbor_source.hpp"
#include "swiftlet/core/guidance/separation_config.hpp"

namespace swiftlet {

/// Optimal reciprocal collision avoidance (van den Berg, Guy, Lin and Manocha, 2011), as a baseline for the rule-based
/// Lloyd algorithm. Each vehicle makes half of the velocity change that keeps a pair apart for the time horizon. Among
/// the velocities that satisfy this for all neighbors, the one nearest to the preferred velocity is flown.
struct OrcaConfig : ModuleConfigOf<OrcaConfig> {
  Eigen::Vector3d goal_m = {0.0, 0.0, 2.0};
  double arrival_radius_m = 0.2;
  double speed_mps = 2.0;
  double encumbrance_m = 0.5;
  double margin_m = 0.1;
  double z_min_m = 1.0;
  double z_max_m = 10.0;
  bool planar = false;
  NeighborSourceConfig neighbors;
  KeepApartConfig separation;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_orca(const ModuleConfig& config, const GuidanceSetup& setup);

/// Velocities v with normal . (v - point) >= 0.
struct OrcaPlane {
  Vector3 point_local_mps = Vector3::Zero();
  Vector3 normal_local = Vector3::UnitX();  ///< unit length
};

/// Constraint on the velocity of a vehicle by another vehicle [van den Berg et al. 2011, sec. 4].
/// @param to_other_local_m  position of the other relative to the vehicle
/// @param distance_m        distance to keep
/// @param horizon_s         time for which the velocities keep this distance
/// @param step_s            time in which vehicles that are already too near separate
OrcaPlane orca_plane(const Vector3& to_other_local_m, const Vector3& v_local_mps, const Vector3& other_v_local_mps,
                     double distance_m, double horizon_s, double step_s);

/// Velocity nearest to the wanted one within all planes and the speed limit. When there is none, all planes are relaxed
/// by the smallest common amount.
Vector3 orca_velocity(std::span<const OrcaPlane> planes, const Vector3& wanted_local_mps, double speed_mps,
                      std::vector<Vector3>& scratch_local_mps);

}  // namespace swiftlet
