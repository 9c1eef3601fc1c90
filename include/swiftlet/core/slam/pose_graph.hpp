// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/slam/graph_config.hpp"

namespace swiftlet {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Residuals longer than `huber` have linear instead of quadratic cost (Huber).
inline constexpr double kNoHuber = std::numeric_limits<double>::infinity();

/// Measured pose `to` relative to pose `from`: within a submap, between submaps, or between key frames.
struct RelativeFactor {
  int from = 0, to = 0;
  Pose T_from_to = Pose::Identity();
  Matrix6 information = Matrix6::Identity();  ///< for position (axes of `from`) and rotation vector (axes of `to`)
  double huber = kNoHuber;
};

/// Measured pose in the world.
struct PriorFactor {
  int pose = 0;
  Pose T_world_pose = Pose::Identity();
  Matrix6 information = Matrix6::Identity();  ///< for position (world axes) and rotation vector (axes of the pose)
};

/// Direction of the vertical in the axes of a pose: tilt measured by the IMU.
struct GravityFactor {
  int pose = 0;
  Vector3 up_body = Vector3::UnitZ();
  double sigma_rad = 1.0;
};

/// Measured position on the straight line between two poses, at the fraction beta [Orsulic 2021, eq. 3].
struct PositionFactor {
  int before = 0, after = 0;
  double beta = 0.0;
  Vector3 p_world_m = Vector3::Zero();
  Vector3 weight_world_1_m = Vector3::Ones();  ///< weight of the residual along each axis
  double huber = kNoHuber;
};

class BlockCholesky;
struct GraphWorkspace;

struct GraphReport {
  int num_iterations = 0;
  double cost_before = 0.0, cost_after = 0.0;
  bool converged = false;
};

/// Sparse, robust pose graph in the world frame. Optimization by Levenberg-Marquardt; budgets count iterations, never
/// time.
class PoseGraph {
 public:
  /// Returns the index of the pose.
  int add_pose(const Pose& T_world_pose);
  void add(const RelativeFactor& factor);
  void add(const PriorFactor& factor);
  void add(const GravityFactor& factor);
  void add(const PositionFactor& factor);

  int num_poses() const { return static_cast<int>(poses_.size()); }
  const Pose& pose(int i) const { return poses_[i]; }
  void set_pose(int i, const Pose& T_world_pose) { poses_[i] = T_world_pose; }
  std::span<const RelativeFactor> relative_factors() const { return relatives_; }
  std::span<const PriorFactor> prior_factors() const { return priors_; }
  std::span<const GravityFactor> gravity_factors() const { return gravities_; }
  std::span<const PositionFactor> position_factors() const { return positions_; }
  /// Removes all poses except the first ones, and every factor that refers to a removed one.
  void truncate(int num_poses);
  /// Removes the priors of a pose and of all later ones.
  void clear_priors(int from = 0) {
    std::erase_if(priors_, [from](const PriorFactor& f) { return f.pose >= from; });
  }

  double cost() const;
  GraphReport optimize(const GraphSolverConfig& config, GraphWorkspace& workspace);
  GraphReport optimize(const GraphSolverConfig& config);
  /// Covariance of a small change of one pose (moved()) under the present factors. The identity when they leave any
  /// pose unconstrained.
  Matrix6 covariance_of(int pose) const;

 private:
  std::vector<std::pair<int, int>> pairs() const;
  double cost_of(std::span<const Pose> poses, std::vector<Vector6>& of_relatives) const;
  void linearize(std::span<const Vector6> of_relatives, BlockCholesky& H, std::vector<Vector6>& gradient) const;

  std::vector<Pose> poses_;
  std::vector<RelativeFactor> relatives_;
  std::vector<PriorFactor> priors_;
  std::vector<GravityFactor> gravities_;
  std::vector<PositionFactor> positions_;
};

}  // namespace swiftlet
