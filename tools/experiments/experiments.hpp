// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "experiment.hpp"

/// The experiments, each in the file of its name; the table of them is registry.cpp.
namespace swiftlet::tools {

void uncertainty_table(Experiment& experiment);
void occupancy_filters(Experiment& experiment);
void expected_error(Experiment& experiment);
void voxel_probability(Experiment& experiment);

// detection.cpp
void detection_ideal(Experiment& experiment);
void detection_noisy(Experiment& experiment);
void detection_multi(Experiment& experiment);  // detection_multi.cpp
void detection_real(Experiment& experiment);
void detection_timing(Experiment& experiment);   // detection_timing.cpp
void detection_choices(Experiment& experiment);  // detection_choices.cpp
void detection_beyond(Experiment& experiment);   // detection_beyond.cpp
void detection_sparse(Experiment& experiment);   // detection_sparse.cpp
void detection_small(Experiment& experiment);    // detection_small.cpp
void detection_shared(Experiment& experiment);   // detection_shared.cpp

void interception(Experiment& experiment);        // interception.cpp
void interception_lidar(Experiment& experiment);  // interception_lidar.cpp
void interception_speed(Experiment& experiment);  // interception_lidar.cpp
void interception_team(Experiment& experiment);   // interception_team.cpp

// Cooperative guidance
void gap_success(Experiment& experiment);      // gap_success.cpp
void forest_guidance(Experiment& experiment);  // forest_guidance.cpp
void narrow_gap(Experiment& experiment);       // narrow_gap.cpp
void guidance_timing(Experiment& experiment);  // guidance_timing.cpp
void communication(Experiment& experiment);    // guidance_timing.cpp

// Graph SLAM in the control loop
void safe_loop_closure(Experiment& experiment);  // safe_loop_closure.cpp
void gps_weighting(Experiment& experiment);      // gps_weighting.cpp
void submap_navigation(Experiment& experiment);  // submap_navigation.cpp
void slam_drift(Experiment& experiment);         // slam_drift.cpp
void slam_limits(Experiment& experiment);        // slam_limits.cpp
void joined_maps(Experiment& experiment);        // joined_maps.cpp

// rbl_crossing.cpp, rbl_forest.cpp, rbl_baselines.cpp
void rbl_circle(Experiment& experiment);
void rbl_circle_printed(Experiment& experiment);
void rbl_circle_files(Experiment& experiment);
void rbl_sphere(Experiment& experiment);
void rbl_sphere_files(Experiment& experiment);
void rbl_forest(Experiment& experiment);
void rbl_forest_files(Experiment& experiment);
void rbl_real(Experiment& experiment);
void rbl_baselines(Experiment& experiment);
void rbl_ghosts(Experiment& experiment);
void rbl_safety(Experiment& experiment);
void rbl_peers(Experiment& experiment);

}  // namespace swiftlet::tools
