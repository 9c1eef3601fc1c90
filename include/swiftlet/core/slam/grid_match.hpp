// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/slam/grid_submaps.hpp"

namespace swiftlet {

using Vector6 = Eigen::Matrix<double, 6, 1>;

struct GridMatchConfig {
  double high_weight = 1.0;
  double low_weight = 6.0;
  double translation_weight_1_m = 5.0;
  double rotation_weight = 400.0;
  int iterations = 12;

  void visit(ConfigVisitor& v);
};

/// The terms of the cost of a pose [Cartographer]. Derivatives are those by a change of the position, then by a
/// rotation vector in body axes.
namespace grid_cost {

/// One minus the probability that a point meets a surface.
struct Miss {
  double r = 0.0;
  Vector6 by_pose = Vector6::Zero();
};
Miss miss_of(const HybridGrid& grid, const Eigen::Vector3f& point_body_m, const Pose& T_grid_body);

/// How far a pose lies from the predicted one. The difference of positions comes first. Then comes the vector part of
/// the quaternion between the attitudes, which is half of their angle.
struct Change {
  Vector6 r = Vector6::Zero();
  Matrix6 by_pose = Matrix6::Zero();
};
Change change_of(const Pose& T, const Pose& T_predicted);

}  // namespace grid_cost

/// Points of a scan, and the grid on which they should lie.
struct GridCloud {
  const HybridGrid* grid = nullptr;
  std::span<const Eigen::Vector3f> points_body_m;
  double weight = 1.0;  ///< of all of them together
};

/// What the points alone say of the pose, beside the prediction: half of `cost` is the sum of their squared residuals.
struct GridEvidence {
  double cost = 0.0;
  Matrix6 H = Matrix6::Zero();  ///< of the cost, by Gauss and Newton
  Vector6 g = Vector6::Zero();  ///< its gradient
  /// Covariance of the gradient, if the points are independent [White 1980].
  Matrix6 scatter = Matrix6::Zero();
};

struct GridsMatch {
  Pose T_local_body = Pose::Identity();
  Vector6 moved = Vector6::Zero();  ///< from the prediction
  GridEvidence evidence;            ///< at that pose
  Vector6 held = Vector6::Zero();   ///< by so much the two terms of the prediction count: they are added to H
  int num_iterations = 0;
};

/// The pose of least cost near the predicted one: occupied space for both clouds, translation and rotation. By
/// Levenberg and Marquardt's method.
GridsMatch match_to_grids(const std::array<GridCloud, 2>& clouds, const Vector3& origin_local_m,
                          const Pose& T_local_body_predicted, const GridMatchConfig& config);

}  // namespace swiftlet
