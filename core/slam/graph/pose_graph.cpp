// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/slam/pose_graph.hpp"

#include <algorithm>
#include <cmath>

#include "core/slam/graph/block_cholesky.hpp"
#include "core/slam/graph/graph_residuals.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/localization/rotation.hpp"

namespace swiftlet {
namespace {

// [-] Ratio of steps below which the cost counts as nearly quadratic. Larger values end the search earlier.
constexpr double kShrinks = 0.1;
/// [-] Damping of the Levenberg-Marquardt method, relative to the diagonal: first value, lower bound, and value that
/// ends the search without a better step. Larger first values and bounds cost iterations.
constexpr double kFirstDamping = 1e-9, kMinDamping = 1e-12, kMaxDamping = 1e6;

/// Derivative of the rotation vector of Exp(r) Exp(turn) by a small turn (inverse of the right Jacobian).
Matrix3 right_jacobian_inverse(const Vector3& r_rad) {
  const Matrix3 K = skew_of(r_rad);
  const double angle = r_rad.norm();
  if (angle < 1e-3) return Matrix3::Identity() + 0.5 * K + (1.0 / 12.0) * (K * K);
  const double sine = elementary::sin(angle), cosine = elementary::cos(angle);
  return Matrix3::Identity() + 0.5 * K + (1.0 / (angle * angle) - (1.0 + cosine) / (2.0 * angle * sine)) * (K * K);
}

/// Factor of a quadratic cost that gives it the derivative of Huber's.
double huber_weight(double length, double scale) { return length <= scale ? 1.0 : scale / length; }

double huber_cost(double length_sq, double scale) {
  if (length_sq <= scale * scale) return 0.5 * length_sq;
  return scale * (std::sqrt(length_sq) - 0.5 * scale);
}

Vector3 turn_to(const Pose& T_a, const Pose& T_b) {
  return rotation_vector_rad(Eigen::Quaterniond(Matrix3(T_a.linear().transpose() * T_b.linear())));
}

Vector6 relative_residual(const RelativeFactor& f, const Pose& T_from, const Pose& T_to) {
  const Matrix3 R_from_to = T_from.linear().transpose() * T_to.linear();
  const Vector3 p_from_m = T_from.linear().transpose() * (T_to.translation() - T_from.translation());
  const Matrix3 R_turn = f.T_from_to.linear().transpose() * R_from_to;
  Vector6 r;
  r << p_from_m - f.T_from_to.translation(), rotation_vector_rad(Eigen::Quaterniond(R_turn));
  return r;
}

Vector6 prior_residual(const PriorFactor& f, const Pose& T) {
  Vector6 r;
  r << T.translation() - f.T_world_pose.translation(), turn_to(f.T_world_pose, T);
  return r;
}

Vector3 gravity_residual(const GravityFactor& f, const Pose& T) { return T.linear().row(2).transpose() - f.up_body; }

/// Equals moved() to first order, as a motion of the world about its origin. Poses that share one motion keep their
/// relative poses, however far it goes, so rotating a long trajectory as a whole has no cost.
Pose carried(const Pose& T_world_pose, const Vector6& step) {
  const Vector3 p_m = T_world_pose.translation();
  const Vector3 turn_rad = T_world_pose.linear() * step.tail<3>();
  const Vector3 shift_m = step.head<3>() - turn_rad.cross(p_m);
  const double angle = turn_rad.norm();
  double a = 0.5 - angle * angle / 24.0, b = 1.0 / 6.0 - angle * angle / 120.0;  // (1 - cos x) / x^2, (x - sin x) / x^3
  if (angle > 1e-2) {
    a = (1.0 - elementary::cos(angle)) / (angle * angle);
    b = (angle - elementary::sin(angle)) / (angle * angle * angle);
  }
  const Vector3 across_m = turn_rad.cross(shift_m);
  const Vector3 along_m = shift_m + a * across_m + b * turn_rad.cross(across_m);
  const Eigen::Quaterniond turn = rotation_by(turn_rad);
  const Eigen::Quaterniond q = turn * Eigen::Quaterniond(Matrix3(T_world_pose.linear()));
  return make_pose(turn * p_m + along_m, q.normalized());
}

/// Contribution of a factor to the normal equations: J^T W J and J^T W r.
struct RelativeTerms {
  Matrix6 H_from, H_to, H_from_to;
  Vector6 g_from, g_to;
};

/// J^T W J and J^T W r of residual_of() by blocks of 3 x 3: J_to is (R 0; 0 K), and J_from is -J_to (I -A; 0 Q) with
/// the lever A of the displacement and the rotation Q between the poses.
RelativeTerms terms_of(const RelativeFactor& f, const Vector6& r, const Pose& T_from, const Pose& T_to) {
  const Vector6 weighted = f.information * r;
  const double w = huber_weight(std::sqrt(r.dot(weighted)), f.huber);
  const Matrix3 R = T_from.linear().transpose(), K = right_jacobian_inverse(r.tail<3>());
  const Matrix3 A = skew_of(T_to.translation() - T_from.translation()) * T_from.linear();
  const Matrix3 Q = T_to.linear().transpose() * T_from.linear();
  RelativeTerms e;
  Matrix6 of_to;  // W J_to
  const Matrix3 weighted_R = w * R, weighted_K = w * K;
  of_to.leftCols<3>().noalias() = f.information.leftCols<3>().lazyProduct(weighted_R);
  of_to.rightCols<3>().noalias() = f.information.rightCols<3>().lazyProduct(weighted_K);
  e.H_to.topRows<3>().noalias() = R.transpose() * of_to.topRows<3>();
  e.H_to.bottomRows<3>().noalias() = K.transpose() * of_to.bottomRows<3>();
  const Matrix3 At = A.transpose(), Qt = Q.transpose();
  e.H_from_to.topRows<3>() = -e.H_to.topRows<3>();
  e.H_from_to.bottomRows<3>().noalias() = At * e.H_to.topRows<3>() - Qt * e.H_to.bottomRows<3>();
  e.H_from.leftCols<3>() = -e.H_from_to.leftCols<3>();
  e.H_from.rightCols<3>().noalias() = e.H_from_to.leftCols<3>() * A - e.H_from_to.rightCols<3>() * Q;
  e.g_to << w * (R.transpose() * weighted.head<3>()), w * (K.transpose() * weighted.tail<3>());
  e.g_from << -e.g_to.head<3>(), At * e.g_to.head<3>() - Qt * e.g_to.tail<3>();
  return e;
}

}  // namespace

Pose moved(const Pose& T_world_pose, const Vector6& step) {
  Pose T;
  const Eigen::Quaterniond q = Eigen::Quaterniond(Matrix3(T_world_pose.linear())) * rotation_by(step.tail<3>());
  return make_pose(T_world_pose.translation() + step.head<3>(), q.normalized());
}

RelativeResidual residual_of(const RelativeFactor& f, const Pose& T_from, const Pose& T_to) {
  RelativeResidual out;
  out.r = relative_residual(f, T_from, T_to);
  const Matrix3 R_from_world = T_from.linear().transpose();
  const Matrix3 of_turn = right_jacobian_inverse(out.r.tail<3>());
  out.J_from.topLeftCorner<3, 3>() = -R_from_world;
  out.J_from.topRightCorner<3, 3>() = skew_of(R_from_world * (T_to.translation() - T_from.translation()));
  out.J_from.bottomRightCorner<3, 3>() = -of_turn * T_to.linear().transpose() * T_from.linear();
  out.J_to.topLeftCorner<3, 3>() = R_from_world;
  out.J_to.bottomRightCorner<3, 3>() = of_turn;
  return out;
}

PriorResidual residual_of(const PriorFactor& f, const Pose& T) {
  PriorResidual out;
  out.r = prior_residual(f, T);
  out.J.topLeftCorner<3, 3>().setIdentity();
  out.J.bottomRightCorner<3, 3>() = right_jacobian_inverse(out.r.tail<3>());
  return out;
}

GravityResidual residual_of(const GravityFactor& f, const Pose& T) {
  return {gravity_residual(f, T), skew_of(T.linear().row(2).transpose())};
}

Vector3 residual_of(const PositionFactor& f, const Pose& T_before, const Pose& T_after) {
  const Vector3 p_m = (1.0 - f.beta) * T_before.translation() + f.beta * T_after.translation();
  return f.weight_world_1_m.cwiseProduct(p_m - f.p_world_m);
}

int PoseGraph::add_pose(const Pose& T_world_pose) {
  poses_.push_back(T_world_pose);
  return num_poses() - 1;
}

void PoseGraph::add(const RelativeFactor& f) {
  ENSURE(f.from != f.to && f.from >= 0 && f.to >= 0 && f.from < num_poses() && f.to < num_poses(), f.from, f.to);
  relatives_.push_back(f);
}

void PoseGraph::add(const PriorFactor& f) {
  ENSURE(f.pose >= 0 && f.pose < num_poses(), f.pose);
  priors_.push_back(f);
}

void PoseGraph::add(const GravityFactor& f) {
  ENSURE(f.pose >= 0 && f.pose < num_poses() && f.sigma_rad > 0.0, f.pose, f.sigma_rad);
  gravities_.push_back(f);
}

void PoseGraph::add(const PositionFactor& f) {
  ENSURE(f.before >= 0 && f.after >= 0 && f.before < num_poses() && f.after < num_poses(), f.before, f.after);
  positions_.push_back(f);
}

void PoseGraph::truncate(int num) {
  ENSURE(num >= 0 && num <= num_poses(), num, num_poses());
  poses_.resize(static_cast<std::size_t>(num));
  std::erase_if(relatives_, [num](const RelativeFactor& f) { return f.from >= num || f.to >= num; });
  std::erase_if(priors_, [num](const PriorFactor& f) { return f.pose >= num; });
  std::erase_if(gravities_, [num](const GravityFactor& f) { return f.pose >= num; });
  std::erase_if(positions_, [num](const PositionFactor& f) { return f.before >= num || f.after >= num; });
}

double PoseGraph::cost() const {
  std::vector<Vector6> of_relatives;
  return cost_of(poses_, of_relatives);
}

/// @param of_relatives  residuals of the relative factors, reused by linearize()
double PoseGraph::cost_of(std::span<const Pose> poses, std::vector<Vector6>& of_relatives) const {
  double cost = 0.0;
  of_relatives.resize(relatives_.size());
  for (std::size_t i = 0; i < relatives_.size(); ++i) {
    const RelativeFactor& f = relatives_[i];
    const Vector6 r = of_relatives[i] = relative_residual(f, poses[f.from], poses[f.to]);
    cost += huber_cost(r.dot(f.information * r), f.huber);
  }
  for (const PriorFactor& f : priors_) {
    const Vector6 r = prior_residual(f, poses[f.pose]);
    cost += 0.5 * r.dot(f.information * r);
  }
  for (const GravityFactor& f : gravities_) {
    cost += 0.5 * gravity_residual(f, poses[f.pose]).squaredNorm() / (f.sigma_rad * f.sigma_rad);
  }
  for (const PositionFactor& f : positions_) {
    cost += huber_cost(residual_of(f, poses[f.before], poses[f.after]).squaredNorm(), f.huber);
  }
  return cost;
}

/// @param of_relatives  residuals of the relative factors at the present poses
void PoseGraph::linearize(std::span<const Vector6> of_relatives, BlockCholesky& H,
                          std::vector<Vector6>& gradient) const {
  H.set_zero();
  gradient.assign(poses_.size(), Vector6::Zero());
  std::size_t pair = 0;  // index in the order of pairs()
  for (const RelativeFactor& f : relatives_) {
    const RelativeTerms e = terms_of(f, of_relatives[pair], poses_[f.from], poses_[f.to]);
    H.diagonal(f.from) += e.H_from;
    H.diagonal(f.to) += e.H_to;
    H.add(pair++, e.H_from_to);
    gradient[f.from] += e.g_from;
    gradient[f.to] += e.g_to;
  }
  for (const PriorFactor& f : priors_) {
    const PriorResidual e = residual_of(f, poses_[f.pose]);
    H.diagonal(f.pose).noalias() += e.J.transpose() * f.information * e.J;
    gradient[f.pose].noalias() += e.J.transpose() * (f.information * e.r);
  }
  for (const GravityFactor& f : gravities_) {
    const GravityResidual e = residual_of(f, poses_[f.pose]);
    const double w = 1.0 / (f.sigma_rad * f.sigma_rad);
    H.diagonal(f.pose).bottomRightCorner<3, 3>() += w * (e.J_turn.transpose() * e.J_turn);
    gradient[f.pose].tail<3>() += w * (e.J_turn.transpose() * e.r_body);
  }
  for (const PositionFactor& f : positions_) {
    const Vector3 r = residual_of(f, poses_[f.before], poses_[f.after]);
    const double w = huber_weight(r.norm(), f.huber);
    const Vector3 information = w * f.weight_world_1_m.cwiseAbs2(), g = w * f.weight_world_1_m.cwiseProduct(r);
    const double one = 1.0 - f.beta, other = f.beta;
    H.diagonal(f.before).diagonal().head<3>() += one * one * information;
    H.diagonal(f.after).diagonal().head<3>() += other * other * information;
    gradient[f.before].head<3>() += one * g;
    gradient[f.after].head<3>() += other * g;
    if (f.before == f.after) {
      H.diagonal(f.before).diagonal().head<3>() += 2.0 * one * other * information;
      continue;
    }
    Matrix6 both = Matrix6::Zero();
    both.diagonal().head<3>() = one * other * information;
    H.add(pair++, both);
  }
}

std::vector<std::pair<int, int>> PoseGraph::pairs() const {
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(relatives_.size() + positions_.size());
  for (const RelativeFactor& f : relatives_) pairs.emplace_back(f.from, f.to);
  for (const PositionFactor& f : positions_) {
    if (f.before != f.after) pairs.emplace_back(f.before, f.after);
  }
  return pairs;
}

Matrix6 PoseGraph::covariance_of(int pose) const {
  ENSURE(pose >= 0 && pose < num_poses(), pose);
  BlockCholesky H(num_poses(), pairs());
  std::vector<Vector6> of_relatives, gradient, column;
  cost_of(poses_, of_relatives);
  linearize(of_relatives, H, gradient);
  if (!H.factorize(0.0)) return Matrix6::Identity();
  Matrix6 covariance = Matrix6::Identity();
  std::vector<Vector6> unit(poses_.size(), Vector6::Zero());
  for (int i = 0; i < 6; ++i) {
    unit[static_cast<std::size_t>(pose)] = Vector6::Unit(i);
    H.solve(unit, column);
    covariance.col(i) = column[static_cast<std::size_t>(pose)];
  }
  return covariance;
}

GraphReport PoseGraph::optimize(const GraphSolverConfig& config) {
  GraphWorkspace workspace;
  return optimize(config, workspace);
}

GraphReport PoseGraph::optimize(const GraphSolverConfig& config, GraphWorkspace& workspace) {
  auto& [H, gradient, step, of_relatives, of_relatives_tried, tried] = workspace;
  H.set_pattern(num_poses(), pairs());
  GraphReport report;
  report.cost_before = report.cost_after = cost_of(poses_, of_relatives);
  tried.resize(poses_.size());
  double damping = kFirstDamping;
  const auto damp = [&] { damping = std::max(damping * 100.0, 1e-6); };
  double last_step = 0.0;  // 0: no step yet
  bool stale = true;
  while (report.num_iterations < config.iterations && damping <= kMaxDamping) {
    if (stale) linearize(of_relatives, H, gradient);
    stale = false;
    ++report.num_iterations;
    if (!H.factorize(damping)) {
      damp();
      continue;
    }
    H.solve(gradient, step);
    double largest = 0.0;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      tried[i] = carried(poses_[i], -step[i]);
      largest = std::max(largest, step[i].cwiseAbs().maxCoeff());
    }
    const double cost = cost_of(tried, of_relatives_tried);
    if (!std::isfinite(cost) || (cost > report.cost_after && largest >= config.step_min)) {
      damp();
      last_step = 0.0;  // a damped step does not predict the next one
      continue;
    }
    if (cost <= report.cost_after) {
      poses_.swap(tried);
      of_relatives.swap(of_relatives_tried);
      report.cost_after = cost;
    }
    stale = true;
    damping = std::max(damping * 0.1, kMinDamping);
    // Steps shrink at least as fast as before: the next step would be smaller than this.
    const double next_step = largest < kShrinks * last_step ? largest * largest / last_step : largest;
    last_step = largest;
    report.converged = next_step < config.step_min;
    if (report.converged) break;
  }
  return report;
}

void GnssFactorConfig::visit(ConfigVisitor& v) {
  v.choice("weighting", weighting, {"isotropic", "per_axis", "released"},
           "weight of a fix along each axis: by the largest deviation of all axes, by its own deviation, or by the "
           "square of that");
  v.field("a", a, "[-] weight of the inverse deviation [Orsulic 2021, eq. 7]", Range::non_negative());
  v.field("b_1_m", b_1_m, "[1/m] constant weight of every fix", Range::non_negative());
  v.field("huber", huber, "[-] Huber threshold of weighted residuals; larger ones count less", Range::positive());
}

}  // namespace swiftlet
