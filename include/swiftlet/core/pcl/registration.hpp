// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <span>

#include "swiftlet/core/base/frames.hpp"

/// PCL's registration methods as functions of two clouds and a guess, as baselines for the scan matchers.
namespace swiftlet {

struct PclRegistration {
  Pose T_target_source = Pose::Identity();
  double fitness_m2 = 0.0;  ///< mean square distance from a source point to the nearest target point
  bool converged = false;   ///< false: too few points, or no convergence
};

/// Settings of Generalized ICP (Segal, Haehnel and Thrun, RSS 2009); PCL's defaults, with distances for a LiDAR.
struct PclGicpSettings {
  double max_correspondence_m = 2.0;
  int num_neighbors = 20;  ///< number of neighbors for the covariance of a point
  int max_iterations = 64;
  double transformation_epsilon = 1e-4;
};

/// Settings of the Normal Distributions Transform (Magnusson, 2009).
struct PclNdtSettings {
  double resolution_m = 1.0;  ///< edge of a cell
  double step_max_m = 0.1;
  double outlier_ratio = 0.55;
  int max_iterations = 64;
  double transformation_epsilon = 1e-4;
};

PclRegistration pcl_gicp(std::span<const Eigen::Vector3f> p_source_m, std::span<const Eigen::Vector3f> p_target_m,
                         const Pose& T_target_source_guess, const PclGicpSettings& settings = {});
PclRegistration pcl_ndt(std::span<const Eigen::Vector3f> p_source_m, std::span<const Eigen::Vector3f> p_target_m,
                        const Pose& T_target_source_guess, const PclNdtSettings& settings = {});

}  // namespace swiftlet
