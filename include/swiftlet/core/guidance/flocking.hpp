// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/guidance/neighbor_source.hpp"
#include "swiftlet/core/guidance/separation_config.hpp"

/// Two other flocking models without communication, as baselines for the rule-based Lloyd algorithm [Kamler 2025, sec.
/// 2.5].
namespace swiftlet {

/// Obstacle avoidance of both models. Neither model defines any: here the nearest occupied voxel at flight height
/// repels the vehicle.
struct FlockObstacleConfig {
  bool enabled = false;

  void visit(ConfigVisitor& v);
};

/// PACNav (Ahmad, Bonilla Licea, Silano, Baca and Saska, 2022). Informed vehicles fly to the goal. Uninformed vehicles
/// follow the neighbor whose path is the most persistent and the most similar to the other paths. All avoid collisions.
/// Both measures in their standard forms:
/// - Persistence is the distance between the ends of the remembered path over its length.
/// - Similarity is the mean cosine between the displacement of the path and those of the other paths.
///
/// All motion is horizontal.
struct PacnavConfig : ModuleConfigOf<PacnavConfig> {
  bool informed = true;
  Eigen::Vector3d goal_m = {0.0, 0.0, 2.0};
  double arrival_radius_m = 0.2;
  double follow_radius_m = 3.0;
  double speed_mps = 1.0;
  double least_persistence = 0.3;
  NeighborSourceConfig neighbors = NeighborSourceConfig::without_memory();
  FlockObstacleConfig lidar;
  KeepApartConfig separation;

  void visit(ConfigVisitor& v) override;
};

/// Purely vision-based model (Bastien and Romanczuk, 2020; Mezey et al., 2024). Speed and turning follow from V, the 1D
/// projection field of the neighbors on the retina, and from its edges:
///   dv/dt = gamma (v0 - v) + int cos(phi) alpha0 (-V + alpha1 |dV/dphi|) dphi,
///   dpsi/dt = int sin(phi) beta0 (-V + beta1 |dV/dphi|) dphi.
/// The model has no goal; `goal_weight_radps` adds a turn toward one (0: as published). Horizontal.
struct MezeyConfig : ModuleConfigOf<MezeyConfig> {
  Eigen::Vector3d goal_m = {0.0, 0.0, 2.0};
  double goal_weight_radps = 0.8;
  double arrival_radius_m = 0.5;
  double cruise_speed_mps = 1.0;
  double relaxation_radps = 0.5;
  double alpha0 = 1.0;
  double alpha1 = 0.12;
  double beta0 = 1.5;
  double beta1 = 0.12;
  double body_radius_m = 0.5;
  NeighborSourceConfig neighbors = NeighborSourceConfig::without_memory();
  FlockObstacleConfig lidar;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_pacnav(const ModuleConfig& config, const GuidanceSetup& setup);
std::unique_ptr<Guidance> make_mezey(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
