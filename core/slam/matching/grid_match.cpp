// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/grid_match.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"

namespace swiftlet {
namespace {

// [-] First damping of the Levenberg-Marquardt method, relative to the diagonal of H. Larger values cost iterations.
constexpr double kGridFirstDamping = 1e-4;
// [-] Smallest factor of the damping, after a step whose gain was as predicted [Nielsen 1999]. Larger values cost
// iterations.
constexpr double kMinEasing = 1.0 / 3.0;
// [-] Share of the cost; a smaller predicted gain ends the search, and so does a damping above 12 over this share,
// which bounds the gain. Smaller values cost iterations.
constexpr double kSettledShare = 1e-6;

Pose changed_pose(const Pose& T, const Vector6& d) {
  return make_pose(T.translation() + d.head<3>(),
                   (Eigen::Quaterniond(T.linear()) * rotation_by(d.tail<3>())).normalized());
}

void mirror_upper(Matrix6& M) {
  M.triangularView<Eigen::StrictlyLower>() = M.transpose().triangularView<Eigen::StrictlyLower>();
}

void add_upper(Matrix6& M, const Vector6& a, double weight) {
  const Vector6 wa = weight * a;
  for (int c = 0; c < 6; ++c) M.col(c).head(c + 1) += a(c) * wa.head(c + 1);
}

GridEvidence evidence_at(const std::array<GridCloud, 2>& clouds, const Pose& T_grid_body, bool with_scatter) {
  GridEvidence e;
  for (const GridCloud& cloud : clouds) {
    if (cloud.points_body_m.empty()) continue;
    const double weight = cloud.weight * cloud.weight / static_cast<double>(cloud.points_body_m.size());
    for (const Eigen::Vector3f& point : cloud.points_body_m) {
      const grid_cost::Miss miss = grid_cost::miss_of(*cloud.grid, point, T_grid_body);
      e.cost += weight * miss.r * miss.r;
      add_upper(e.H, miss.by_pose, weight);
      e.g += weight * miss.r * miss.by_pose;
      if (with_scatter) add_upper(e.scatter, miss.by_pose, weight * weight * miss.r * miss.r);
    }
  }
  mirror_upper(e.H);
  mirror_upper(e.scatter);
  return e;
}

/// Total cost at a pose.
struct WholeCost {
  GridEvidence points;
  double cost = 0.0;
  Matrix6 H;
  Vector6 g;
};

class Problem {
 public:
  Problem(const std::array<GridCloud, 2>& clouds, const Vector3& origin_local_m, const Pose& T_predicted,
          const GridMatchConfig& config)
      : clouds_(clouds), origin_local_m_(origin_local_m), T_predicted_(T_predicted) {
    weight_ << Vector3::Constant(config.translation_weight_1_m), Vector3::Constant(config.rotation_weight);
  }
  GridEvidence points_at(const Pose& T, bool with_scatter) const {
    Pose T_grid_body = T;
    T_grid_body.translation() -= origin_local_m_;
    return evidence_at(clouds_, T_grid_body, with_scatter);
  }
  WholeCost at(const Pose& T) const {
    WholeCost whole;
    whole.points = points_at(T, false);
    const grid_cost::Change change = grid_cost::change_of(T, T_predicted_);
    const Vector6 r = weight_.cwiseProduct(change.r);
    const Matrix6 J = weight_.asDiagonal() * change.by_pose;
    whole.cost = whole.points.cost + r.squaredNorm();
    whole.H = whole.points.H + J.transpose() * J;
    whole.g = whole.points.g + J.transpose() * r;
    return whole;
  }
  /// Information of the translation and rotation terms at the predicted pose.
  Vector6 held() const {
    Vector6 held = weight_.cwiseProduct(weight_);
    held.tail<3>() *= 0.25;
    return held;
  }

 private:
  const std::array<GridCloud, 2>& clouds_;
  Vector3 origin_local_m_;
  Pose T_predicted_;
  Vector6 weight_;
};

}  // namespace

grid_cost::Miss grid_cost::miss_of(const HybridGrid& grid, const Eigen::Vector3f& point_body_m,
                                   const Pose& T_grid_body) {
  const Vector3 x_body_m = point_body_m.cast<double>();
  const HybridGrid::Interpolated at = grid.interpolate(T_grid_body * x_body_m);
  Miss miss;
  miss.r = 1.0 - at.probability;
  miss.by_pose << -at.slope_1_m, -x_body_m.cross(T_grid_body.linear().transpose() * at.slope_1_m);
  return miss;
}

grid_cost::Change grid_cost::change_of(const Pose& T, const Pose& T_predicted) {
  Eigen::Quaterniond turn = Eigen::Quaterniond(T_predicted.linear()).conjugate() * Eigen::Quaterniond(T.linear());
  if (turn.w() < 0.0) turn.coeffs() *= -1.0;
  Change change;
  change.r << T.translation() - T_predicted.translation(), turn.vec();
  change.by_pose.topLeftCorner<3, 3>().setIdentity();
  change.by_pose.bottomRightCorner<3, 3>() = 0.5 * (turn.w() * Matrix3::Identity() + skew_of(turn.vec()));
  return change;
}

GridsMatch match_to_grids(const std::array<GridCloud, 2>& clouds, const Vector3& origin_local_m,
                          const Pose& T_local_body_predicted, const GridMatchConfig& config) {
  const Problem problem(clouds, origin_local_m, T_local_body_predicted, config);
  GridsMatch match;
  match.T_local_body = T_local_body_predicted;
  WholeCost here = problem.at(match.T_local_body);
  double damping = kGridFirstDamping, harder = 2.0;
  for (; match.num_iterations < config.iterations; ++match.num_iterations) {
    Matrix6 damped = here.H;
    damped.diagonal() *= 1.0 + damping;
    const Vector6 step = damped.partialPivLu().solve(-here.g);
    if (!step.allFinite()) break;
    const Pose T_next = changed_pose(match.T_local_body, step);
    const WholeCost next = problem.at(T_next);
    const double predicted = -step.dot(2.0 * here.g + here.H * step), gain = here.cost - next.cost;
    if (predicted < kSettledShare * here.cost) break;
    if (gain <= 0.0) {  // each further rejection raises the damping more (Nielsen 1999)
      damping *= harder;
      harder *= 2.0;
      continue;
    }
    const double deviation = 2.0 * gain / predicted - 1.0;
    damping *= std::max(kMinEasing, 1.0 - deviation * deviation * deviation);
    harder = 2.0;
    match.T_local_body = T_next;
    here = next;
  }
  match.evidence = problem.points_at(match.T_local_body, true);
  match.held = problem.held();
  match.moved << match.T_local_body.translation() - T_local_body_predicted.translation(),
      rotation_vector_rad(Eigen::Quaterniond(T_local_body_predicted.linear()).conjugate() *
                          Eigen::Quaterniond(match.T_local_body.linear()));
  return match;
}

}  // namespace swiftlet
