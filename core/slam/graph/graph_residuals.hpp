// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

/// Residuals of the factors of a pose graph.
namespace swiftlet {

/// Applies a displacement in world axes and a rotation in the pose's own axes.
Pose moved(const Pose& T_world_pose, const Vector6& step);

/// Residuals and their derivatives with respect to such changes; a row per residual.
struct RelativeResidual {
  Vector6 r = Vector6::Zero();
  Matrix6 J_from = Matrix6::Zero(), J_to = Matrix6::Zero();
};
RelativeResidual residual_of(const RelativeFactor& factor, const Pose& T_world_from, const Pose& T_world_to);
struct PriorResidual {
  Vector6 r = Vector6::Zero();
  Matrix6 J = Matrix6::Zero();
};
PriorResidual residual_of(const PriorFactor& factor, const Pose& T_world_pose);
struct GravityResidual {
  Vector3 r_body = Vector3::Zero();
  Matrix3 J_turn = Matrix3::Zero();
};
GravityResidual residual_of(const GravityFactor& factor, const Pose& T_world_pose);
/// Weighted residual; its derivatives are (1 - beta) and beta times the weights.
Vector3 residual_of(const PositionFactor& factor, const Pose& T_world_before, const Pose& T_world_after);

}  // namespace swiftlet
