// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/guidance/neighbor_memory.hpp"

namespace swiftlet {

/// Optimal reciprocal collision avoidance (van den Berg, Guy, Lin and Manocha, 2011), to compare the rule-based Lloyd
/// algorithm with. Each vehicle takes half of the change of velocity that keeps two apart for a while. Of all
/// velocities that do so with every neighbor it flies the one nearest to what it would like to fly.
struct OrcaConfig : ModuleConfigOf<OrcaConfig> {
  Eigen::Vector3d goal_m = {0.0, 0.0, 2.0};
  double arrival_radius_m = 0.2;
  double speed_mps = 2.0;
  double encumbrance_m = 0.5;
  double margin_m = 0.1;
  double horizon_s = 4.0;
  double turn_deg = 5.0;
  double z_min_m = 1.0;
  double z_max_m = 10.0;
  bool planar = false;
  NeighborSourceConfig neighbors;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_orca(const ModuleConfig& config, const GuidanceSetup& setup);

/// Velocities v with normal . (v - point) >= 0.
struct OrcaPlane {
  Vector3 point_local_mps = Vector3::Zero();
  Vector3 normal_local = Vector3::UnitX();  ///< unit length
};

/// What a vehicle owes to another one.
/// @param to_other_local_m  from the vehicle
/// @param distance_m        to keep
/// @param horizon_s         for how long
/// @param step_s            those that are too near already are to be apart after that
OrcaPlane orca_plane(const Vector3& to_other_local_m, const Vector3& v_local_mps, const Vector3& other_v_local_mps,
                     double distance_m, double horizon_s, double step_s);

/// The velocity nearest to the wanted one that keeps all planes and the speed. When there is none, the planes give way
/// by the same amount until there is.
Vector3 orca_velocity(std::span<const OrcaPlane> planes, const Vector3& wanted_local_mps, double speed_mps,
                      std::vector<Vector3>& scratch_local_mps);

}  // namespace swiftlet
