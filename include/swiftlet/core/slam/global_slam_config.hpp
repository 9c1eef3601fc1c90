// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/slam/closure_config.hpp"
#include "swiftlet/core/slam/graph_config.hpp"
#include "swiftlet/core/slam/map_sharing_config.hpp"
#include "swiftlet/core/slam/saved_map.hpp"

namespace swiftlet {

/// Form of the blend of a new correction. Both forms of the document apply a part at once.
enum class BlendForm {
  kLimited,   ///< no step: speed, acceleration and jerk are limited
  kPrinted,   ///< eq. 2 of [Orsulic 2021] as printed: a step of 6.9 %
  kReleased,  ///< released program of the authors: a step of 1.1 %
  kNone,      ///< full step
};

struct CorrectionBlendConfig {
  BlendForm form = BlendForm::kLimited;
  double speed_max_mps = 0.25;
  double acceleration_max_mps2 = 0.1;
  /// [m] distance from the vehicle up to which points keep the limits; larger values turn the map more slowly
  double lever_m = 10.0;

  void visit(ConfigVisitor& v);
};

struct GlobalSlamConfig {
  bool enabled = false;
  double latency_s = 0.3;
  double node_every_m = 0.5;    ///< [m] flown distance between nodes of the graph
  double submap_m = 8.0;        ///< [m] flown distance after which the next submap begins
  double submap_voxel_m = 0.2;  ///< [m] edge of the cubes in which a submap keeps one point
  double covered_share = 0.7;
  int visits_kept = 6;
  double closure_distance_m = 8.0;  ///< [m] largest distance between two submaps that are compared
  double closure_gap_m = 30.0;      ///< [m] least flown distance between two submaps that are compared
  int searches = 2;
  /// [m/sqrt(m)] position noise of local SLAM per root of the flown distance, as assumed by the graph
  double odometry_position_m_sqrt_m = 0.02;
  /// [deg/sqrt(m)] attitude noise of local SLAM per root of the flown distance, as assumed by the graph
  double odometry_attitude_deg_sqrt_m = 0.1;
  double closure_position_m = 0.02;   ///< [m] standard deviation of a closure's position
  double closure_attitude_deg = 0.1;  ///< [deg] standard deviation of a closure's attitude
  double closure_huber = 3.0;  ///< [-] Huber threshold of closures, in standard deviations; larger residuals count less
  double gravity_sigma_deg = 0.2;  ///< [deg] standard deviation of the tilt from local SLAM
  bool use_gnss = true;
  double optimize_every_s = 10.0;
  std::string map;
  std::shared_ptr<const SavedMap> loaded_map;  ///< content of the file `map`, read by the creator of the vehicle
  GnssFactorConfig gnss;
  ClosureConfig closures;
  CorrectionBlendConfig blend;
  MapSharingConfig share;

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet
