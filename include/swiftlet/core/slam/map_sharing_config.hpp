// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/slam/closure.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {

/// Transmitted part of a submap.
struct CompactCloudConfig {
  double voxel_m = 0.5;
  double flat_voxel_m = 1.5;
  double range_max_m = 25.0;
  int upright_points = 1200;
  int bits = 5;
  int chunk_bytes = 1000;

  void visit(ConfigVisitor& v);
};

/// Acceptance of closures between two vehicles.
struct MapJoinConfig {
  int closures_min = 2;
  double chi2_max = 16.81;
  double closure_position_m = 0.03;
  double closure_attitude_deg = 0.1;
  double odometry_position_m_sqrt_m = 0.02;
  double odometry_attitude_deg_sqrt_m = 0.05;
  double closure_huber = 3.0;
  double gravity_sigma_deg = 0.2;
  GraphSolverConfig graph;

  void visit(ConfigVisitor& v);
};

/// Exchange of submaps by radio, to estimate the relative pose of the vehicles' local frames.
struct MapSharingConfig {
  bool enabled = false;
  double latency_s = 0.5;
  double budget_kbps = 100.0;
  double tell_every_s = 5.0;
  double ask_again_s = 3.0;
  double likeness_min = 0.5;
  int search_submaps = 8;
  double near_m = 12.0;
  int closures_enough = 8;
  CompactCloudConfig cloud;
  ClosureConfig search = global_closure_config();
  MapJoinConfig join;

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet
