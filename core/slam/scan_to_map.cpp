// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/slam/scan_to_map.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/slam/symmetric_eigen.hpp"

namespace swiftlet {
namespace {

// Normals that are off by a little make an open direction seem to hang on the others: those count less then.
constexpr double kOpenFloor = 10.0;
constexpr double kNoiseFactor = 3.0;  // information of noise that is taken for none

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Weight of a residual by the robust kernel; 1 near zero.
double kernel(double distance_sq, double kernel_sq) {
  const double k = kernel_sq / (kernel_sq + distance_sq);
  return k * k;
}

/// Sums of one kind of residuals.
struct Sums {
  Matrix6 H = Matrix6::Zero();  // the upper half
  Vector6 g = Vector6::Zero();
  double weight = 0.0, lever_m2 = 0.0;

  void add(const Vector3& x_body_m, const Vector3& n_local, const Matrix3& R_local_body, double r_m, double w) {
    Vector6 J;
    J << n_local, x_body_m.cross(R_local_body.transpose() * n_local);
    const Vector6 wJ = w * J;
    for (int c = 0; c < 6; ++c) H.col(c).head(c + 1) += J(c) * wJ.head(c + 1);
    g += r_m * wJ;
    weight += w;
    lever_m2 += w * x_body_m.squaredNorm();
  }
  Matrix6 whole() const {
    Matrix6 full = H;
    full.triangularView<Eigen::StrictlyLower>() = H.transpose().triangularView<Eigen::StrictlyLower>();
    return full;
  }
};

/// Takes out what the planes do not tell: directions in which their information, with turns counted by the mean lever
/// arm, is but a small share of the whole.
int remove_unobserved(PoseEvidence& evidence, const Sums& planes, double least_share) {
  Vector6 scale;
  scale << Vector3::Ones(), Vector3::Constant(std::sqrt(planes.lever_m2 / planes.weight));
  const Vector6 inverse = scale.cwiseInverse();
  const SymmetricEigen<6> eigen =
      symmetric_eigen<6>(Matrix6(inverse.asDiagonal() * planes.whole() * inverse.asDiagonal()));
  int removed = 0;
  Matrix6 keep = Matrix6::Identity();
  for (int i = 0; i < 6; ++i) {
    if (eigen.values(i) >= least_share * planes.weight) continue;
    keep -= eigen.vectors.col(i) * eigen.vectors.col(i).transpose();
    ++removed;
  }
  if (removed == 0) return 0;
  const Matrix6 scaled = inverse.asDiagonal() * evidence.information * inverse.asDiagonal();
  evidence.information = scale.asDiagonal() * (keep * scaled * keep) * scale.asDiagonal();
  evidence.gradient = (scale.asDiagonal() * (keep * (inverse.asDiagonal() * evidence.gradient))).eval();
  return removed;
}

/// Errors that all points of a scan share do not average out: their covariance is added to that of the pose, which is
/// the inverse of the information. (Omega^-1 + F)^-1 = Omega - Omega (F^-1 + Omega)^-1 Omega.
void add_floor(PoseEvidence& evidence, const ScanToMapConfig& config, double times, double smear_m) {
  Vector6 floor_inverse;
  const double angle_rad = times * config.floor_attitude_deg * kRadPerDeg;
  const double position_m = elementary::hypot(times * config.floor_position_m, smear_m);
  floor_inverse << Vector3::Constant(1.0 / (position_m * position_m)), Vector3::Constant(1.0 / (angle_rad * angle_rad));
  const Matrix6 Omega = evidence.information;
  const Matrix6 sum = Matrix6(floor_inverse.asDiagonal()) + Omega;
  const Matrix6 gain = sum.partialPivLu().solve(Omega).transpose();  // Omega (F^-1 + Omega)^-1
  evidence.information = Omega - gain * Omega;
  evidence.information = (0.5 * (evidence.information + evidence.information.transpose())).eval();
  evidence.gradient -= (gain * evidence.gradient).eval();
}

}  // namespace

ScanFit fit_scan(const SurfaceMap& map, std::span<const Eigen::Vector3f> points_body_m, const Pose& T_local_body,
                 const ScanToMapConfig& config, double smear_m) {
  ScanFit fit;
  fit.num_points = static_cast<int>(points_body_m.size());
  const Matrix3 R = T_local_body.linear();
  const Vector3 p = T_local_body.translation();
  const double kernel_sq = config.kernel_sigma * config.kernel_sigma;
  const double floor_m2 = config.surface_sigma_m * config.surface_sigma_m;
  Sums planes, points;
  double noise = 0.0;  // what errors of the normals add to the information of any direction
  for (const Eigen::Vector3f& point : points_body_m) {
    const Vector3 x = point.cast<double>();
    const Vector3 at = R * x + p;
    const SurfaceCell* cell = map.find(at);
    if (cell == nullptr) continue;
    ++fit.num_known;
    if (!map.is_full(*cell)) ++fit.num_fresh;
    const Vector3 off = at - cell->mean_m.cast<double>();
    if (cell->planar) {
      ++fit.num_planar;
      const Vector3 n = cell->normal.cast<double>();
      const double r = n.dot(off);
      if (std::abs(r) > config.reach_m) continue;
      // Scatter of the point about the plane, and of the plane where the point is.
      const double in_plane_m2 = off.squaredNorm() - r * r;
      const double normal_variance = cell->variance_m2 / (cell->count_fitted * cell->narrow_variance_m2);
      const double variance =
          floor_m2 + cell->variance_m2 * (1.0 + 1.0 / cell->count_fitted) + in_plane_m2 * normal_variance;
      const double distance_sq = r * r / variance;
      if (distance_sq < 9.0) ++fit.num_near;
      const double weight = kernel(distance_sq, kernel_sq) / variance;
      planes.add(x, n, R, r, weight);
      noise += weight * normal_variance;
    } else if (config.point_weight > 0.0) {
      const double variance = floor_m2 + cell->variance_m2 + 2.0 * cell->narrow_variance_m2;  // by axis, generously
      const double distance_sq = off.squaredNorm() / variance;
      if (distance_sq < 9.0) ++fit.num_near;
      const double weight = config.point_weight * kernel(distance_sq, kernel_sq) / variance;
      for (int axis = 0; axis < 3; ++axis) points.add(x, Vector3::Unit(axis), R, off(axis), weight);
    }
  }
  if (!(planes.weight > 0.0)) {
    fit.num_degenerate = 6;
    return fit;
  }
  fit.evidence.information = planes.whole() + points.whole();
  fit.evidence.gradient = planes.g + points.g;
  const double least_share = std::max(config.degenerate_share, kNoiseFactor * noise / planes.weight);
  fit.num_degenerate = remove_unobserved(fit.evidence, planes, least_share);
  add_floor(fit.evidence, config, fit.num_degenerate > 0 ? kOpenFloor : 1.0, smear_m);
  return fit;
}

void ScanToMapConfig::visit(ConfigVisitor& v) {
  v.field("kernel_sigma", kernel_sigma, "[-] residuals beyond so many standard deviations hardly count",
          Range::between(0.5, 100.0));
  v.field("reach_m", reach_m, "[m] points farther than this from a plane do not belong to it",
          Range::between(0.01, 10.0));
  v.field("surface_sigma_m", surface_sigma_m, "[m] how rough the smoothest surface is taken to be",
          Range::between(1e-4, 1.0));
  v.field("point_weight", point_weight, "[-] of points where the map has no plane; 0: they are left out",
          Range::probability());
  v.field("degenerate_share", degenerate_share,
          "[-] a direction of which the scan tells less than this share of all is not observed",
          Range::between(0.0, 0.3));
  v.field("floor_position_m", floor_position_m, "[m] standard deviation of what all points of a scan have in common",
          Range::positive());
  v.field("floor_attitude_deg", floor_attitude_deg, "[deg] the same of the attitude", Range::positive());
}

}  // namespace swiftlet
