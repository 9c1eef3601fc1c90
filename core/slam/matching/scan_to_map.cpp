// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/scan_to_map.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/slam/symmetric_eigen.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// [-] Factor of the noise floor while a direction is open: slightly wrong normals couple an open direction to the
// others. Larger values weigh scans less while a direction is open.
constexpr double kOpenFloor = 60.0;
// [m] Largest distance of a point from its plane. Larger values match scans with worse predictions, and more wrong
// pairs.
constexpr double kReach_m = 0.5;
// [m^2] Upper bound of the floor in the variance of a map plane. A wider floor accepts points farther away, but does
// not make the planes less certain.
constexpr double kFlat_m2 = 1e-4;
// [-] Multiple of the information from noise below which a direction is open. Larger values open more directions.
constexpr double kNoiseFactor = 3.0;
// [-] Share of the information that firm planes must have so that the others are left out. Larger values keep curves of
// single beams where surfaces are seen sparsely.
constexpr double kFirmShare = 0.5;
// Constants of the test for free-standing structure.
// [m] Distance tested before and behind a point: more than the thickness of a stem, less than the distance between
// stems.
constexpr double kStep_m = 0.7;
// [-] Least sine of the angle between surface and direction: 17 degrees. Larger values find fewer points.
constexpr double kAcross = 0.3;
// [-] Least motion per unit: points near the axis of a rotation hardly constrain it. Larger values find fewer points.
constexpr double kMinMotion = 0.25;
// [m] Largest lateral distance at which a beam passes beside a point, and least distance of its end behind the
// continued surface. A larger first or smaller second value takes more surfaces for ended ones.
constexpr double kBeside_m = 1.5, kBeyond_m = 0.5;
// [-] Fewest points with a passing beam. Smaller values take gaps between scan lines for the end of a surface.
constexpr int kMinPassed = 3;
// [m] Largest position error with which a free-standing point is recognized. Larger values find a place again after a
// longer drift; from kStep_m on they confuse neighboring stems.
constexpr double kRecognized_m = 0.5;

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Weight of a residual by the robust kernel; 1 near zero. Points within its width lie on the surface.
double kernel(double distance_sq, double kernel_sq) {
  const double k = kernel_sq / (kernel_sq + distance_sq);
  return k * k;
}

/// Sums over one kind of residuals.
struct Sums {
  Matrix6 H = Matrix6::Zero();  // the upper half
  Vector6 g = Vector6::Zero();
  double weight = 0.0, lever_m2 = 0.0;
  // Planes only: information that errors of their normals add to any direction; weight of the scan if the map were
  // exact; the map's share of the variance, and the part that the scan would renew.
  double noise = 0.0, of_scan = 0.0, of_map = 0.0, renewed = 0.0;

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
  double variance_m2 = 0.0;  // scatter of the point about the plane plus the plane's own uncertainty at the point
};

PlaneDistance distance_from_plane(const SurfaceCell& cell, const Vector3& off_m, double floor_m2) {
  PlaneDistance d;
  d.r_m = cell.normal.cast<double>().dot(off_m);
  const double in_plane_m2 = off_m.squaredNorm() - d.r_m * d.r_m;
  const double slope_variance = cell.variance_m2 / (cell.count_fitted * cell.narrow_variance_m2);
  d.variance_m2 = floor_m2 + cell.variance_m2 * (1.0 + 1.0 / cell.count_fitted) + in_plane_m2 * slope_variance;
  return d;
}

/// A scan at its present pose.
struct PlacedScan {
  const SurfaceMap& map;
  std::span<const Eigen::Vector3f> points_body_m;
  Matrix3 R_local_body;
  Vector3 p_local_m;
  double floor_m2, kernel_sq, range_variance_m2;

  Vector3 place(const Vector3& x_body_m) const { return R_local_body * x_body_m + p_local_m; }
};

}  // namespace

/// Points of a scan that meet one plane of the map. A point at (u, v) from the center of the cell, along its axis and
/// aside, measures (1, u, v) times the offset and the two slopes of the scan's plane relative to the map's.
class ScanFitter::MetPlane {
 public:
  explicit MetPlane(const SurfaceCell& cell) : cell_(&cell) {}

  void add(const Vector3& off_m, double r_m, double weight) {
    const Vector3 A(1.0, cell_->axis.cast<double>().dot(off_m), cell_->aside().cast<double>().dot(off_m));
    M_ += weight * A * A.transpose();
    s_ += weight * r_m * A;
  }
  void add_to(Sums& sums, const PlacedScan& scan) const;
  const SurfaceCell* cell() const { return cell_; }

 private:
  Vector3 variances(const PlacedScan& scan, const Vector3& lever_m) const;

  const SurfaceCell* cell_;
  Matrix3 M_ = Matrix3::Zero();  // information of the scan's plane
  Vector3 s_ = Vector3::Zero();
};

/// Variances of offset and slopes of the map's plane. Scatter explained by range noise averages out; the excess does
/// not. The variance of n points is itself uncertain by a share of sqrt(2 / n).
Vector3 ScanFitter::MetPlane::variances(const PlacedScan& scan, const Vector3& lever_m) const {
  const double n = cell_->count_fitted, across = lever_m.normalized().dot(cell_->normal.cast<double>());
  const double explained_m2 = scan.range_variance_m2 * across * across * (1.0 + 2.0 * std::sqrt(2.0 / n));
  const double mean_m2 = (std::min(scan.floor_m2, kFlat_m2) + cell_->variance_m2) / n;
  return {mean_m2 + std::max(0.0, cell_->variance_m2 - explained_m2), mean_m2 / cell_->wide_variance_m2,
          mean_m2 / cell_->narrow_variance_m2};
}

/// Offset and slopes depend linearly on the pose, through B. The map's plane is marginalized as an unknown with a
/// prior.
void ScanFitter::MetPlane::add_to(Sums& sums, const PlacedScan& scan) const {
  const Vector3 lever_m = cell_->mean_m.cast<double>() - scan.p_local_m;
  const Vector3 N_inverse = variances(scan, lever_m);
  const Matrix3 gain = M_ * (M_ + Matrix3(N_inverse.cwiseInverse().asDiagonal())).inverse();
  const Matrix3 W = M_ - gain * M_;  // (M^-1 + N^-1)^-1
  const Vector3 normal = cell_->normal.cast<double>();
  const Matrix3 R_body_local = scan.R_local_body.transpose();
  Eigen::Matrix<double, 3, 6> B = Eigen::Matrix<double, 3, 6>::Zero();
  B.row(0) << normal.transpose(), (R_body_local * lever_m.cross(normal)).transpose();
  B.row(1).tail<3>() = R_body_local * cell_->aside().cast<double>();
  B.row(2).tail<3>() = -(R_body_local * cell_->axis.cast<double>());
  const Eigen::Matrix<double, 3, 6> WB = W * B;
  sums.H += B.transpose() * WB;
  sums.g += B.transpose() * (s_ - gain * s_);
  sums.weight += W(0, 0);
  sums.lever_m2 += W(0, 0) * lever_m.squaredNorm();
  sums.noise += W(0, 0) * N_inverse.z();
  sums.of_scan += M_(0, 0);
  sums.of_map += W.col(0).dot(N_inverse.asDiagonal() * W.col(0));
  if (!scan.map.is_full(*cell_)) sums.renewed += M_(0, 0) - W(0, 0);
}

/// One entry per cell, in the order in which the points meet the cells.
class ScanFitter::MetPlanes {
 public:
  void clear(std::size_t most) {
    table_.assign(std::max(table_.size(), std::bit_ceil(2 * most + 1)), 0);
    all_.clear();
  }
  MetPlane& at(const SurfaceCell& cell) {
    const std::size_t mask = table_.size() - 1;
    for (std::size_t slot = reinterpret_cast<std::uintptr_t>(&cell) / sizeof(SurfaceCell) & mask;;
         slot = (slot + 1) & mask) {
      if (table_[slot] == 0) {
        all_.emplace_back(cell);
        table_[slot] = static_cast<std::uint32_t>(all_.size());
      }
      if (all_[table_[slot] - 1].cell() == &cell) return all_[table_[slot] - 1];
    }
  }
  std::span<const MetPlane> all() const { return all_; }

 private:
  std::vector<std::uint32_t> table_;  // index + 1; 0: empty
  std::vector<MetPlane> all_;
};

namespace {

/// Weakly constrained directions of the pose; rotations are scaled by a lever arm.
struct WeakDirections {
  Vector6 scale;
  int num = 0;
  std::array<Vector6, 6> axes;  // unit vectors

  /// Directions whose information, with rotations scaled by the mean lever arm, is a small share of that of all planes.
  WeakDirections(const Sums& planes, double least_share) {
    scale << Vector3::Ones(), Vector3::Constant(std::sqrt(planes.lever_m2 / planes.weight));
    const Vector6 inverse = scale.cwiseInverse();
    const SymmetricEigen<6> eigen =
        symmetric_eigen<6>(Matrix6(inverse.asDiagonal() * planes.whole() * inverse.asDiagonal()));
    least_share = std::max(least_share, kNoiseFactor * planes.noise / planes.weight);
    for (int i = 0; i < 6; ++i) {
      if (eigen.values(i) < least_share * planes.weight) axes[num++] = eigen.vectors.col(i);
    }
  }

  /// Displacement of a point per unit of direction i, in local axes.
  Vector3 motion(int i, const PlacedScan& scan, const Vector3& x_body_m) const {
    const Vector6 twist = axes[i].cwiseQuotient(scale);
    return twist.head<3>() + scan.R_local_body * twist.tail<3>().cross(x_body_m);
  }
};

/// True when no surface of the map explains a point at this place.
bool is_bare(const PlacedScan& scan, const Vector3& at_m) {
  const SurfaceCell* cell = scan.map.find(at_m, scan.p_local_m);
  if (cell == nullptr) return true;
  const Vector3 off_m = at_m - cell->mean_m.cast<double>();
  if (cell->planar) {
    const PlaneDistance d = distance_from_plane(*cell, off_m, scan.floor_m2);
    return d.r_m * d.r_m > scan.kernel_sq * d.variance_m2;
  }
  if (cell->narrow_variance_m2 > kPoleSigma_m * kPoleSigma_m) return true;  // a large cell that mixes several objects
  const double across_m = cell->normal.cast<double>().dot(off_m), aside_m = cell->aside().cast<double>().dot(off_m);
  return across_m * across_m > scan.kernel_sq * (scan.floor_m2 + cell->variance_m2) ||
         aside_m * aside_m > scan.kernel_sq * (scan.floor_m2 + cell->narrow_variance_m2);
}

/// True if a beam passes beside a point, ahead or behind along a direction, through the continuation of a smooth
/// surface: the surface then ends there. `aside` is the other direction within that surface. Directions are unit
/// vectors of the body frame, from whose origin the beams are assumed to come.
bool is_passed(const PlacedScan& scan, const Vector3& x_body_m, const Vector3& along, const Vector3& aside) {
  const Vector3 normal = along.cross(aside);
  const double here_m = -normal.dot(x_body_m);  // signed distance of the sensor from the surface
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

/// Evidence of points that stand free along weak directions.
struct Standing {
  struct Residual {
    Vector6 J;  // scaled
    double r_m = 0.0, weight = 0.0;
    unsigned free_along = 0;  // a bit for each weak direction
  };
  std::vector<Residual> residuals;
  std::array<int, 6> num_points{};
  std::array<int, 6> num_passed{};  // number of these points beside which a beam passes; counted up to the limit
};

Standing find_standing(const PlacedScan& scan, const WeakDirections& weak, double position_sigma_m) {
  Standing standing;
  const double predicted_m2 =
      std::min(position_sigma_m * position_sigma_m, kRecognized_m * kRecognized_m / scan.kernel_sq);
  for (const Eigen::Vector3f& point : scan.points_body_m) {
    const Vector3 x = point.cast<double>(), at = scan.place(x);
    const SurfaceCell* cell = scan.map.find(at, scan.p_local_m);
    if (cell != nullptr && !cell->planar) cell = scan.map.find_pole(at);
    if (cell == nullptr) continue;
    // A plane constrains one direction, a pole the two across it.
    const int num = cell->planar ? 1 : 2;
    const Vector3 off = at - cell->mean_m.cast<double>();
    const std::array<Vector3, 2> n = {cell->normal.cast<double>(), cell->aside().cast<double>()};
    std::array<PlaneDistance, 2> d = {distance_from_plane(*cell, off, scan.floor_m2), {}};
    if (!cell->planar) {
      const double inflation = 1.0 + 1.0 / cell->count_fitted;
      d[0].variance_m2 = scan.floor_m2 + cell->variance_m2 * inflation;
      d[1] = {n[1].dot(off), scan.floor_m2 + cell->narrow_variance_m2 * inflation};
    }
    double distance_sq = 0.0, predicted_sq = 0.0;
    for (int k = 0; k < num; ++k) {
      distance_sq += d[k].r_m * d[k].r_m / d[k].variance_m2;
      predicted_sq += d[k].r_m * d[k].r_m / (d[k].variance_m2 + predicted_m2);
    }
    if (predicted_sq > scan.kernel_sq) continue;
    unsigned free_along = 0;
    for (int i = 0; i < weak.num; ++i) {
      const Vector3 motion = weak.motion(i, scan, x);
      const double length = motion.norm();
      double across = std::abs(n[0].dot(motion));
      if (num == 2) across = std::max(across, std::abs(n[1].dot(motion)));
      if (length < kMinMotion || across < kAcross * length) continue;
      const Vector3 shift_m = kStep_m / length * motion;
      if (!is_bare(scan, at + shift_m) || !is_bare(scan, at - shift_m)) continue;
      free_along |= 1U << i;
      ++standing.num_points[i];
      if (standing.num_passed[i] >= kMinPassed) continue;
      // The surface that may only seem to end here because scan lines are few: through the pole, or along the plane.
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
      standing.residuals.push_back(
          {J.cwiseQuotient(weak.scale), d[k].r_m, kernel(distance_sq, scan.kernel_sq) / d[k].variance_m2, free_along});
    }
  }
  return standing;
}

/// Removes directions that the planes do not constrain. Free-standing structure along such a direction still constrains
/// it; all other points are excluded there, because their normals are slightly off.
void remove_unobserved(ScanFit& fit, const PlacedScan& scan, const WeakDirections& weak, int least_standing,
                       double position_sigma_m) {
  const Vector6 inverse = weak.scale.cwiseInverse();
  Matrix6 keep = Matrix6::Identity();
  for (int i = 0; i < weak.num; ++i) keep -= weak.axes[i] * weak.axes[i].transpose();
  const Matrix6 scaled = inverse.asDiagonal() * fit.evidence.information * inverse.asDiagonal();
  Matrix6 H = keep * scaled * keep;
  Vector6 g = keep * (inverse.asDiagonal() * fit.evidence.gradient);
  const Standing standing = find_standing(scan, weak, position_sigma_m);
  unsigned held = 0;
  for (int i = 0; i < weak.num; ++i) {
    const bool holds = standing.num_points[i] >= least_standing && standing.num_passed[i] >= kMinPassed;
    held |= static_cast<unsigned>(holds) << i;
    ++(holds ? fit.num_held : fit.num_degenerate);
  }
  for (const Standing::Residual& residual : standing.residuals) {
    if ((residual.free_along & held) == 0) continue;
    Vector6 J = keep * residual.J;
    for (int i = 0; i < weak.num; ++i) {
      if ((residual.free_along & held & 1U << i) != 0) J += weak.axes[i] * weak.axes[i].dot(residual.J);
    }
    H += residual.weight * J * J.transpose();
    g += residual.weight * residual.r_m * J;
  }
  fit.evidence.information = weak.scale.asDiagonal() * H * weak.scale.asDiagonal();
  fit.evidence.gradient = (weak.scale.asDiagonal() * g).eval();
}

/// Adds the covariance of errors common to all points of a scan, which do not average out, to that of the pose, the
/// inverse of the information. (Omega^-1 + F)^-1 = Omega - Omega (F^-1 + Omega)^-1 Omega.
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

ScanFitter::ScanFitter() : met_(std::make_unique<MetPlanes>()) {}
ScanFitter::~ScanFitter() = default;

ScanFit fit_scan(const SurfaceMap& map, std::span<const Eigen::Vector3f> points_body_m, const Pose& T_local_body,
                 const ScanToMapConfig& config, double smear_m, double range_sigma_m, double position_sigma_m) {
  return ScanFitter().fit(map, points_body_m, T_local_body, config, smear_m, range_sigma_m, position_sigma_m);
}

ScanFit ScanFitter::fit(const SurfaceMap& map, std::span<const Eigen::Vector3f> points_body_m, const Pose& T_local_body,
                        const ScanToMapConfig& config, double smear_m, double range_sigma_m, double position_sigma_m) {
  ScanFit fit;
  fit.num_points = static_cast<int>(points_body_m.size());
  const Matrix3 R = T_local_body.linear();
  const double floor_m2 = config.surface_sigma_m * config.surface_sigma_m;
  const double kernel_sq = config.kernel_sigma * config.kernel_sigma;
  const PlacedScan scan{
      map, points_body_m, R, T_local_body.translation(), floor_m2, kernel_sq, range_sigma_m * range_sigma_m};
  Sums points;
  met_->clear(points_body_m.size());
  for (const Eigen::Vector3f& point : points_body_m) {
    const Vector3 x = point.cast<double>();
    const Vector3 at = scan.place(x);
    const SurfaceCell* cell = map.find(at, scan.p_local_m);
    if (cell == nullptr) continue;
    ++fit.num_known;
    const Vector3 off = at - cell->mean_m.cast<double>();
    if (cell->planar) {
      const PlaneDistance d = distance_from_plane(*cell, off, floor_m2);
      if (std::abs(d.r_m) > kReach_m) continue;
      const double distance_sq = d.r_m * d.r_m / d.variance_m2;
      if (distance_sq < kernel_sq) ++fit.num_near;
      met_->at(*cell).add(off, d.r_m, kernel(distance_sq, kernel_sq) / (floor_m2 + cell->variance_m2));
    } else if (config.point_weight > 0.0) {
      // conservative variance per axis
      const double variance = floor_m2 + cell->variance_m2 + 2.0 * cell->narrow_variance_m2;
      const double distance_sq = off.squaredNorm() / variance;
      if (distance_sq < kernel_sq) ++fit.num_near;
      const double weight = config.point_weight * kernel(distance_sq, kernel_sq) / variance;
      for (int axis = 0; axis < 3; ++axis) points.add(x, Vector3::Unit(axis), R, off(axis), weight);
    }
  }
  const auto sum_of_planes = [&](float least_points) {
    Sums sum;
    for (const MetPlane& plane : met_->all()) {
      if (plane.cell()->count_fitted >= least_points) plane.add_to(sum, scan);
    }
    return sum;
  };
  Sums planes = sum_of_planes(0.0F);
  if (planes.weight > 0.0 && WeakDirections(planes, config.degenerate_share).num > 0) {
    const Sums firm = sum_of_planes(config.firm_points);
    if (firm.weight > kFirmShare * planes.weight) planes = firm;
  }
  if (!(planes.weight > 0.0)) {
    fit.num_degenerate = 6;
    return fit;
  }
  fit.evidence.information = planes.whole() + points.whole();
  fit.evidence.gradient = planes.g + points.g;
  fit.map_share = planes.of_map / planes.weight;
  fit.renewal = planes.renewed / planes.of_scan;
  const WeakDirections weak(planes, config.degenerate_share);
  if (weak.num > 0) remove_unobserved(fit, scan, weak, config.standing_points, position_sigma_m);
  add_floor(fit.evidence, config, fit.num_degenerate > 0 ? kOpenFloor : 1.0, smear_m);
  return fit;
}

void ScanToMapConfig::visit(ConfigVisitor& v) {
  v.field("degenerate_share", degenerate_share,
          "[-] share of the planes' information below which a direction counts as open", Range::between(0.0, 0.3));
  v.field("standing_points", standing_points,
          "[-] fewest points on free-standing surfaces, such as stems, that constrain an open direction",
          Range::between(1, 1000000));
}

}  // namespace swiftlet
