// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/slam/scan_to_map.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/slam/symmetric_eigen.hpp"

namespace swiftlet {
namespace {

// Normals that are off by a little make an open direction seem to hang on the others: those count less then.
constexpr double kOpenFloor = 10.0;
constexpr double kNoiseFactor = 3.0;  // information of noise that is taken for none
constexpr double kNear_sq = 9.0;      // squared standard deviations within which a point lies on a surface
// What stands free.
constexpr double kStep_m = 0.7;        // ahead and behind: more than the thickness of a stem, less than their distance
constexpr double kAcross = 0.3;        // sine of the angle of a surface against the direction: 17 degrees
constexpr double kLeastMotion = 0.25;  // points near the axis of a turn hardly move, so they tell nothing of it
constexpr double kBeside_m = 1.5;      // a beam as near as this goes by beside a point
constexpr double kBeyond_m = 0.5;      // and ends at least so far behind the surface that it would have met
constexpr int kLeastPassed = 3;        // points beside which beams have to go by
constexpr double kSpread_m = 0.15;     // a cell without plane whose points are spread by more is no single thing

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

/// Distance of a point from the plane of its cell.
struct PlaneDistance {
  double r_m = 0.0;
  double variance_m2 = 0.0;      // scatter of the point about the plane, and of the plane where the point is
  double normal_variance = 0.0;  // rad^2, of the plane's normal
};

PlaneDistance distance_from_plane(const SurfaceCell& cell, const Vector3& off_m, double floor_m2) {
  PlaneDistance d;
  d.r_m = cell.normal.cast<double>().dot(off_m);
  const double in_plane_m2 = off_m.squaredNorm() - d.r_m * d.r_m;
  d.normal_variance = cell.variance_m2 / (cell.count_fitted * cell.narrow_variance_m2);
  d.variance_m2 = floor_m2 + cell.variance_m2 * (1.0 + 1.0 / cell.count_fitted) + in_plane_m2 * d.normal_variance;
  return d;
}

/// A scan where it is now.
struct PlacedScan {
  const SurfaceMap& map;
  std::span<const Eigen::Vector3f> points_body_m;
  Matrix3 R_local_body;
  Vector3 p_local_m;
  double floor_m2, kernel_sq;

  Vector3 place(const Vector3& x_body_m) const { return R_local_body * x_body_m + p_local_m; }
};

/// Directions of the pose in which turns are counted by a lever arm.
struct WeakDirections {
  Vector6 scale;
  int num = 0;
  std::array<Vector6, 6> axes;  // unit vectors

  /// How a point moves with a unit of one of them, in local axes.
  Vector3 motion(int i, const PlacedScan& scan, const Vector3& x_body_m) const {
    const Vector6 twist = axes[i].cwiseQuotient(scale);
    return twist.head<3>() + scan.R_local_body * twist.tail<3>().cross(x_body_m);
  }
};

/// Is there no surface that a point at this place would lie on?
bool is_bare(const PlacedScan& scan, const Vector3& at_m) {
  const SurfaceCell* cell = scan.map.find(at_m);
  if (cell == nullptr) return true;
  const Vector3 off_m = at_m - cell->mean_m.cast<double>();
  if (cell->planar) {
    const PlaneDistance d = distance_from_plane(*cell, off_m, scan.floor_m2);
    return d.r_m * d.r_m > kNear_sq * d.variance_m2;
  }
  if (cell->narrow_variance_m2 > kSpread_m * kSpread_m) return true;  // a large cell of several things
  const double across_m = cell->normal.cast<double>().dot(off_m), aside_m = cell->aside().cast<double>().dot(off_m);
  return across_m * across_m > kNear_sq * (scan.floor_m2 + cell->variance_m2) ||
         aside_m * aside_m > kNear_sq * (scan.floor_m2 + cell->narrow_variance_m2);
}

/// Does a beam go by beside a point, ahead or behind along a direction, through where a smooth surface would go on?
/// Then there is none. The other direction within that surface is `aside`. All are unit vectors of the body frame, from
/// whose origin beams are taken to come.
bool is_passed(const PlacedScan& scan, const Vector3& x_body_m, const Vector3& along, const Vector3& aside) {
  const Vector3 normal = along.cross(aside);
  const double here_m = -normal.dot(x_body_m);  // of the sensor from the surface
  const double side = here_m < 0.0 ? -1.0 : 1.0;
  for (const Eigen::Vector3f& point : scan.points_body_m) {
    const Vector3 end = point.cast<double>();
    const double beyond_m = -side * normal.dot(end - x_body_m);
    if (beyond_m < kBeyond_m) continue;
    const double share = std::abs(here_m) / (std::abs(here_m) + beyond_m);
    const Vector3 beside = share * end - x_body_m;
    if (std::abs(along.dot(beside)) < kBeside_m && std::abs(aside.dot(beside)) < kBeside_m) return true;
  }
  return false;
}

/// What points tell that stand free along weak directions.
struct Standing {
  struct Residual {
    Vector6 J;  // scaled
    double r_m = 0.0, weight = 0.0;
    unsigned free_along = 0;  // a bit for each weak direction
    bool of_plane = false;    // then it counts among the planes already
  };
  std::vector<Residual> residuals;
  std::array<int, 6> num_points{};
  std::array<int, 6> num_passed{};  // of these, beside which a beam goes by, as far as it has to be counted
};

Standing find_standing(const PlacedScan& scan, const WeakDirections& weak) {
  Standing standing;
  for (const Eigen::Vector3f& point : scan.points_body_m) {
    const Vector3 x = point.cast<double>(), at = scan.place(x);
    const SurfaceCell* cell = scan.map.find(at);
    if (cell != nullptr && !cell->planar) cell = scan.map.find_pole(at);
    if (cell == nullptr) continue;
    // A plane tells of one direction, a pole of the two across it.
    const int num = cell->planar ? 1 : 2;
    const Vector3 off = at - cell->mean_m.cast<double>();
    const std::array<Vector3, 2> n = {cell->normal.cast<double>(), cell->aside().cast<double>()};
    std::array<PlaneDistance, 2> d = {distance_from_plane(*cell, off, scan.floor_m2), {}};
    if (!cell->planar) {
      const double unsure = 1.0 + 1.0 / cell->count_fitted;
      d[0].variance_m2 = scan.floor_m2 + cell->variance_m2 * unsure;
      d[1] = {n[1].dot(off), scan.floor_m2 + cell->narrow_variance_m2 * unsure, 0.0};
    }
    double distance_sq = 0.0;
    for (int k = 0; k < num; ++k) distance_sq += d[k].r_m * d[k].r_m / d[k].variance_m2;
    if (distance_sq > kNear_sq) continue;
    unsigned free_along = 0;
    for (int i = 0; i < weak.num; ++i) {
      const Vector3 motion = weak.motion(i, scan, x);
      const double length = motion.norm();
      double across = std::abs(n[0].dot(motion));
      if (num == 2) across = std::max(across, std::abs(n[1].dot(motion)));
      if (length < kLeastMotion || across < kAcross * length) continue;
      const Vector3 shift_m = kStep_m / length * motion;
      if (!is_bare(scan, at + shift_m) || !is_bare(scan, at - shift_m)) continue;
      free_along |= 1U << i;
      ++standing.num_points[i];
      if (standing.num_passed[i] >= kLeastPassed) continue;
      // The surface that only seems to end here, as one of a few scan lines does: through the pole, or along the plane.
      const Vector3 along = motion / length;
      Vector3 aside = num == 2 ? Vector3(cell->axis.cast<double>()) : n[0].cross(along);
      if (aside.norm() < kAcross) aside = along.unitOrthogonal();
      aside = (aside - along.dot(aside) * along).normalized();
      const Matrix3 R_body_local = scan.R_local_body.transpose();
      standing.num_passed[i] += is_passed(scan, x, R_body_local * along, R_body_local * aside) ? 1 : 0;
    }
    if (free_along == 0) continue;
    for (int k = 0; k < num; ++k) {
      Vector6 J;
      J << n[k], x.cross(scan.R_local_body.transpose() * n[k]);
      standing.residuals.push_back({J.cwiseQuotient(weak.scale), d[k].r_m,
                                    kernel(distance_sq, scan.kernel_sq) / d[k].variance_m2, free_along, cell->planar});
    }
  }
  return standing;
}

/// Takes out what the planes do not tell: directions in which their information, with turns counted by the mean lever
/// arm, is but a small share of the whole. What stands free along such a direction tells of it all the same; all other
/// points are then taken to say nothing of it, as their normals are off by a little.
void remove_unobserved(ScanFit& fit, const PlacedScan& scan, const Sums& planes, double least_share,
                       int least_standing) {
  WeakDirections weak;
  weak.scale << Vector3::Ones(), Vector3::Constant(std::sqrt(planes.lever_m2 / planes.weight));
  const Vector6 inverse = weak.scale.cwiseInverse();
  const SymmetricEigen<6> eigen =
      symmetric_eigen<6>(Matrix6(inverse.asDiagonal() * planes.whole() * inverse.asDiagonal()));
  Matrix6 keep = Matrix6::Identity();
  for (int i = 0; i < 6; ++i) {
    if (eigen.values(i) >= least_share * planes.weight) continue;
    keep -= eigen.vectors.col(i) * eigen.vectors.col(i).transpose();
    weak.axes[weak.num++] = eigen.vectors.col(i);
  }
  if (weak.num == 0) return;
  const Matrix6 scaled = inverse.asDiagonal() * fit.evidence.information * inverse.asDiagonal();
  Matrix6 H = keep * scaled * keep;
  Vector6 g = keep * (inverse.asDiagonal() * fit.evidence.gradient);
  const Standing standing = find_standing(scan, weak);
  unsigned held = 0;
  for (int i = 0; i < weak.num; ++i) {
    const bool holds = standing.num_points[i] >= least_standing && standing.num_passed[i] >= kLeastPassed;
    held |= static_cast<unsigned>(holds) << i;
    ++(holds ? fit.num_held : fit.num_degenerate);
  }
  for (const Standing::Residual& residual : standing.residuals) {
    if ((residual.free_along & held) == 0) continue;
    const Vector6 J_kept = keep * residual.J;
    Vector6 J = J_kept;
    for (int i = 0; i < weak.num; ++i) {
      if ((residual.free_along & held & 1U << i) != 0) J += weak.axes[i] * weak.axes[i].dot(residual.J);
    }
    H += residual.weight * J * J.transpose();
    g += residual.weight * residual.r_m * J;
    if (!residual.of_plane) continue;
    H -= residual.weight * J_kept * J_kept.transpose();
    g -= residual.weight * residual.r_m * J_kept;
  }
  fit.evidence.information = weak.scale.asDiagonal() * H * weak.scale.asDiagonal();
  fit.evidence.gradient = (weak.scale.asDiagonal() * g).eval();
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
  const double floor_m2 = config.surface_sigma_m * config.surface_sigma_m;
  const double kernel_sq = config.kernel_sigma * config.kernel_sigma;
  const PlacedScan scan{map, points_body_m, R, T_local_body.translation(), floor_m2, kernel_sq};
  Sums planes, points;
  double noise = 0.0;  // what errors of the normals add to the information of any direction
  for (const Eigen::Vector3f& point : points_body_m) {
    const Vector3 x = point.cast<double>();
    const Vector3 at = scan.place(x);
    const SurfaceCell* cell = map.find(at);
    if (cell == nullptr) continue;
    ++fit.num_known;
    if (!map.is_full(*cell)) ++fit.num_fresh;
    const Vector3 off = at - cell->mean_m.cast<double>();
    if (cell->planar) {
      ++fit.num_planar;
      const PlaneDistance d = distance_from_plane(*cell, off, floor_m2);
      if (std::abs(d.r_m) > config.reach_m) continue;
      const double distance_sq = d.r_m * d.r_m / d.variance_m2;
      if (distance_sq < kNear_sq) ++fit.num_near;
      const double weight = kernel(distance_sq, kernel_sq) / d.variance_m2;
      planes.add(x, cell->normal.cast<double>(), R, d.r_m, weight);
      noise += weight * d.normal_variance;
    } else if (config.point_weight > 0.0) {
      const double variance = floor_m2 + cell->variance_m2 + 2.0 * cell->narrow_variance_m2;  // by axis, generously
      const double distance_sq = off.squaredNorm() / variance;
      if (distance_sq < kNear_sq) ++fit.num_near;
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
  remove_unobserved(fit, scan, planes, least_share, config.standing_points);
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
          "[-] a direction of which planes tell less than this share of all is not observed", Range::between(0.0, 0.3));
  v.field("standing_points", standing_points,
          "[-] so many points on surfaces that stand free along such a direction, as stems do, tell of it all the same",
          Range::between(1, 1000000));
  v.field("floor_position_m", floor_position_m, "[m] standard deviation of what all points of a scan have in common",
          Range::positive());
  v.field("floor_attitude_deg", floor_attitude_deg, "[deg] the same of the attitude", Range::positive());
}

}  // namespace swiftlet
