// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/frames.hpp"
#include "swiftlet/core/slam/block_cholesky.hpp"

namespace swiftlet {

/// A residual whose length is more than `scale` counts by its length, not by its square (Huber).
inline constexpr double kNoHuber = std::numeric_limits<double>::infinity();

/// Where pose `to` lies as seen from pose `from`: within a submap, between submaps, or from key frame to key frame.
struct RelativeFactor {
  int from = 0, to = 0;
  Pose T_from_to = Pose::Identity();
  Matrix6 information = Matrix6::Identity();  ///< of position (axes of `from`) and rotation vector (axes of `to`)
  double huber = kNoHuber;
};

/// Where a pose lies in the world.
struct PriorFactor {
  int pose = 0;
  Pose T_world_pose = Pose::Identity();
  Matrix6 information = Matrix6::Identity();  ///< of position (world axes) and rotation vector (axes of the pose)
};

/// Which way is up, in the axes of a pose: what the IMU tells of its tilt.
struct GravityFactor {
  int pose = 0;
  Vector3 up_body = Vector3::UnitZ();
  double sigma_rad = 1.0;
};

/// A position on the straight line between two poses, at the share beta of it [Orsulic 2021, eq. 3].
struct PositionFactor {
  int before = 0, after = 0;
  double beta = 0.0;
  Vector3 p_world_m = Vector3::Zero();
  Vector3 weight_world_1_m = Vector3::Ones();  ///< by axis, of the residual
  double huber = kNoHuber;
};

/// How the standard deviations of a GNSS fix weight it.
enum class GnssWeighting {
  kIsotropic,  ///< all axes by the worst [Orsulic 2021, eq. 6]
  kPerAxis,    ///< each by its own [eq. 5]
  kReleased,   ///< each by the square of its own, as the authors released it
};

struct GnssFactorConfig {
  GnssWeighting weighting = GnssWeighting::kIsotropic;
  double a = 1.0;
  double b_1_m = 0.0;
  double huber = 1.0;

  void visit(ConfigVisitor& v);
};

/// a / sigma + b by axis [Orsulic 2021, eq. 7].
Vector3 gnss_weight_1_m(const GnssFactorConfig& config, const Vector3& sigma_world_m);

struct GraphSolverConfig {
  int iterations = 20;
  double step_min = 1e-6;

  void visit(ConfigVisitor& v);
};

struct GraphReport {
  int num_iterations = 0;
  double cost_before = 0.0, cost_after = 0.0;
  bool converged = false;
};

/// What an optimization needs beside the graph. Whoever keeps it for the next one saves the time to take new memory, a
/// tenth of all for 10 000 nodes.
struct GraphWorkspace {
  BlockCholesky H;
  std::vector<Vector6> gradient, step, of_relatives, of_relatives_tried;
  std::vector<Pose> tried;
};

/// Poses in the world and what is known of them, sparse and robust. Optimization is by Levenberg and Marquardt; budgets
/// count iterations, never time.
class PoseGraph {
 public:
  /// Returns its index.
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
  /// Forgets all poses but the first ones, and every factor that needs another one.
  void truncate(int num_poses);
  /// Of all poses from this one on.
  void clear_priors(int from = 0) {
    std::erase_if(priors_, [from](const PriorFactor& f) { return f.pose >= from; });
  }

  double cost() const;
  GraphReport optimize(const GraphSolverConfig& config, GraphWorkspace& workspace);
  GraphReport optimize(const GraphSolverConfig& config) {
    GraphWorkspace workspace;
    return optimize(config, workspace);
  }
  /// Of a small change of one pose (moved()), given all factors as they stand now. The identity when they leave any
  /// pose open.
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

/// Poses change by a displacement in world axes and a turn in their own.
Pose moved(const Pose& T_world_pose, const Vector6& step);

/// Residuals and derivatives by such changes; a row per residual.
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
/// Weighted; its derivatives are (1 - beta) and beta times the weights.
Vector3 residual_of(const PositionFactor& factor, const Pose& T_world_before, const Pose& T_world_after);

/// A point of a trajectory and where it was measured to be.
struct MatchedPosition {
  Vector3 p_local_m = Vector3::Zero(), p_world_m = Vector3::Zero();
  double weight = 1.0;
};
/// The pose of the local frame in the world that fits best, by heading and translation: both have z up. The heading
/// stays what it is (`yaw_rad`) where the points are too near to each other to tell one.
Pose fit_to_world(std::span<const MatchedPosition> points, double yaw_rad, double least_spread_m);

}  // namespace swiftlet
