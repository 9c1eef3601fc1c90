// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>

#include "core/slam/matching/grid_submaps.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/slam/grid_matching_config.hpp"

namespace swiftlet {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Terms of the cost of a pose [Cartographer]. Derivatives are with respect to a change of position, then a rotation
/// vector in body axes.
namespace grid_cost {

/// Residual of a point: one minus the probability of a surface there.
struct Miss {
  double r = 0.0;
  Vector6 by_pose = Vector6::Zero();
};
Miss miss_of(const HybridGrid& grid, const Eigen::Vector3f& point_body_m, const Pose& T_grid_body);

/// Residual of a pose relative to its prediction: difference of positions, then the vector part of the quaternion
/// between the attitudes, half of their angle.
struct Change {
  Vector6 r = Vector6::Zero();
  Matrix6 by_pose = Matrix6::Zero();
};
Change change_of(const Pose& T, const Pose& T_predicted);

}  // namespace grid_cost

/// Points of a scan, and the grid that they are matched to.
struct GridCloud {
  const HybridGrid* grid = nullptr;
  std::span<const Eigen::Vector3f> points_body_m;
  double weight = 1.0;  ///< total weight of the points
};

/// Contribution of the points alone, without the prediction; `cost` is half of the sum of their squared residuals.
struct GridEvidence {
  double cost = 0.0;
  Matrix6 H = Matrix6::Zero();  ///< Gauss-Newton Hessian of the cost
  Vector6 g = Vector6::Zero();  ///< gradient of the cost
  /// Covariance of the gradient for independent points [White 1980].
  Matrix6 scatter = Matrix6::Zero();
};

struct GridsMatch {
  Pose T_local_body = Pose::Identity();
  Vector6 moved = Vector6::Zero();  ///< step from the prediction
  GridEvidence evidence;            ///< at that pose
  Vector6 held = Vector6::Zero();   ///< diagonal of the prediction's terms, to be added to H
  int num_iterations = 0;
};

/// Pose of least cost near the predicted one: occupied space for both clouds, translation and rotation.
/// Levenberg-Marquardt.
GridsMatch match_to_grids(const std::array<GridCloud, 2>& clouds, const Vector3& origin_local_m,
                          const Pose& T_local_body_predicted, const GridMatchConfig& config);

}  // namespace swiftlet
