// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/closure_alignment.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/slam/graph/closure_search.hpp"
#include "core/slam/graph/graph_residuals.hpp"
#include "core/slam/matching/matching_limits.hpp"
#include "core/slam/symmetric_eigen.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// [-] Points of the newer submap in an alignment. More of them cost time and do not improve it.
constexpr std::size_t kMaxFitted = 5000;
// Standard deviations of the surfaces [m], coarse to fine. The coarsest associates points as far off as a cell of the
// grid. The finest stands for the drift that bends each submap a little; below it, fewer points lie on surfaces.
constexpr double kSurfaceSigmas_m[] = {0.3, 0.1, 0.03, 0.01};
// Indices of the deviation in the search for the height, and in all verification. A wider one accepts wrong heights.
constexpr std::size_t kHeight = 1, kFinest = std::size(kSurfaceSigmas_m) - 1;
// [-] Gauss-Newton steps per deviation. Fewer of them end before the alignment has converged.
constexpr int kMaxIterations = 8;
// [deg] Attitude error of a guess, one standard deviation. Smaller values hold the alignment to a wrong attitude.
constexpr double kAttitudeSigma_deg = 1.0;
// [-] Share of the information below which a direction counts as unobserved when a prior can keep it. Normals of a
// thinned cloud are off by up to 8 degrees, which alone can produce such a share. Smaller values take that for
// evidence.
constexpr double kUnobservedShare = 0.02;
// [m] Translation per unit step below which a direction is a pure rotation. Larger values ignore its line.
constexpr double kMinTranslation_m = 0.1;
// [m] Sampling distance along the least observed direction. Larger values miss ledges, smaller ones cost time.
constexpr double kShift_m = 0.15;
// [-] A submap that still has more than this share of its points on surfaces after a shift of two sampling distances or
// more does not observe the direction. Larger values constrain directions by errors of normals.
constexpr double kHeldShare = 0.95;

ScanToMapConfig matching_of(std::size_t step, bool allows_unobserved) {
  ScanToMapConfig matching;
  if (allows_unobserved) matching.degenerate_share = kUnobservedShare;
  matching.firm_points = 0.0F;  // thinned clouds have few points a plane
  matching.surface_sigma_m = kSurfaceSigmas_m[step];
  return matching;
}

SurfaceMap surfaces_of(std::span<const Eigen::Vector3f> points_m) {
  SurfaceMapConfig config;
  config.two_faced = false;  // the points of a submap are seen from many places
  SurfaceMap surfaces{config};
  std::vector<Vector3> exact_m(points_m.size());
  for (std::size_t i = 0; i < exact_m.size(); ++i) exact_m[i] = points_m[i].cast<double>();
  surfaces.insert(exact_m, Vector3::Zero());
  return surfaces;
}

/// Step by which moved() takes T_from to T_to.
Vector6 step_between(const Pose& T_from, const Pose& T_to) {
  Vector6 step;
  step << T_to.translation() - T_from.translation(),
      rotation_vector_rad(Eigen::Quaterniond(Matrix3(T_from.linear().transpose() * T_to.linear())));
  return step;
}

/// Directions of a pose, the least observed first. A unit step along a direction moves points by 1 m on average:
/// rotations are scaled by the mean lever arm.
struct Directions {
  explicit Directions(const PoseEvidence& evidence) {
    const Matrix6& information = evidence.information;
    const double lever_sq = information.diagonal().tail<3>().sum() / information.diagonal().head<3>().sum();
    scale << Vector3::Ones(), Vector3::Constant(std::sqrt(std::max(lever_sq, 1.0)));
    const Vector6 inverse = scale.cwiseInverse();
    vectors = symmetric_eigen<6>(Matrix6(inverse.asDiagonal() * information * inverse.asDiagonal())).vectors;
  }
  Vector6 step(int i) const { return vectors.col(i).cwiseQuotient(scale); }

  Vector6 scale;
  Matrix6 vectors;  // eigenvectors in scaled steps
};

}  // namespace

SubmapPair::SubmapPair(std::span<const Eigen::Vector3f> points_older_m, std::span<const Eigen::Vector3f> points_newer_m,
                       std::span<const Eigen::Vector3f> upright_points_newer_m)
    : surfaces(surfaces_of(points_older_m)),
      newer_m(points_newer_m),
      upright_newer_m(upright_points_newer_m),
      fitted_newer_m(points_newer_m.begin(), points_newer_m.end()) {
  keep_at_most(kMaxFitted, fitted_newer_m);
}

PosePrior prior_of(const Pose& T_older_newer_guess, double largest_error_m) {
  PosePrior prior{T_older_newer_guess};
  const double sigma_m = largest_error_m / kErrorSigmas, sigma_rad = kAttitudeSigma_deg * kRadPerDeg;
  prior.information.diagonal() << Vector3::Constant(1.0 / (sigma_m * sigma_m)),
      Vector3::Constant(1.0 / (sigma_rad * sigma_rad));
  return prior;
}

int align(const SubmapPair& pair, const std::optional<PosePrior>& prior, Reach reach, Pose& T_older_newer) {
  ScanFitter fitter;
  for (auto k = static_cast<std::size_t>(reach); k <= kFinest; ++k) {
    const ScanToMapConfig matching = matching_of(k, prior.has_value());
    for (int i = 0; i < kMaxIterations; ++i) {
      const ScanFit fit = fitter.fit(pair.surfaces, pair.fitted_newer_m, T_older_newer, matching);
      if (fit.num_degenerate > 0 && !prior) return fit.num_degenerate;
      PoseEvidence evidence = fit.evidence;
      if (prior) {
        evidence.information += prior->information;
        evidence.gradient += prior->information * step_between(prior->T_older_newer, T_older_newer);
      }
      const Vector6 step = evidence.information.ldlt().solve(evidence.gradient);
      if (!step.allFinite()) return 6;  // as if no direction were observed
      T_older_newer = moved(T_older_newer, -step);
      if (step.cwiseAbs().maxCoeff() < kConverged) break;
    }
  }
  return fitter.fit(pair.surfaces, pair.fitted_newer_m, T_older_newer, matching_of(kFinest, prior.has_value()))
      .num_degenerate;
}

void align_height(const SubmapPair& pair, double cell_m, Pose& T_older_newer) {
  const ScanToMapConfig matching = matching_of(kHeight, false);
  const double z_m = T_older_newer.translation().z();
  double best_m = z_m;
  int most = -1;
  ScanFitter fitter;
  for (const int halves : {0, 1, -1, 2, -2}) {
    T_older_newer.translation().z() = z_m + 0.5 * cell_m * halves;
    const int near = fitter.fit(pair.surfaces, pair.fitted_newer_m, T_older_newer, matching).num_near;
    if (near <= most) continue;
    most = near;
    best_m = T_older_newer.translation().z();
  }
  T_older_newer.translation().z() = best_m;
}

ScanFit fit_finely(const SubmapPair& pair, std::span<const Eigen::Vector3f> points_newer_m, const Pose& T_older_newer,
                   bool allows_unobserved) {
  return fit_scan(pair.surfaces, points_newer_m, T_older_newer, matching_of(kFinest, allows_unobserved));
}

Matrix6 observed_directions(const PoseEvidence& evidence, int num_unobserved) {
  if (num_unobserved == 0) return Matrix6::Identity();
  const Directions of(evidence);
  Matrix6 kept = Matrix6::Identity();
  for (int i = 0; i < num_unobserved; ++i) kept -= of.vectors.col(i) * of.vectors.col(i).transpose();
  return of.scale.cwiseInverse().asDiagonal() * kept * of.scale.asDiagonal();
}

std::size_t ShiftedPoses::best() const {
  return static_cast<std::size_t>(std::max_element(num_near.begin(), num_near.end()) - num_near.begin());
}

bool ShiftedPoses::fits_elsewhere() const {
  for (std::size_t i = 1; i < offset_m.size(); ++i) {
    if (std::abs(offset_m[i]) >= 2.0 * kShift_m && num_near[i] > kHeldShare * num_near.front()) return true;
  }
  return false;
}

double ShiftedPoses::distance_from_line_m(const Pose& T) const {
  const Vector3 off_m = T.translation() - T_older_newer.front().translation();
  if (step.head<3>().norm() < kMinTranslation_m) return off_m.norm();
  const Vector3 along = step.head<3>().normalized();
  return (off_m - off_m.dot(along) * along).norm();
}

ShiftedPoses sample_shifts(const SubmapPair& pair, const Pose& T_older_newer, double reach_m) {
  ENSURE(std::isfinite(reach_m), reach_m);
  ScanFitter fitter;
  const ScanToMapConfig matching = matching_of(kFinest, true);
  const ScanFit fit = fitter.fit(pair.surfaces, pair.fitted_newer_m, T_older_newer, matching);
  ShiftedPoses shifts{fit.evidence, Directions(fit.evidence).step(0), {T_older_newer}, {0.0}, {fit.num_near}};
  const int num_steps = static_cast<int>(std::ceil(reach_m / kShift_m));
  for (int i = 1; i <= num_steps; ++i) {
    for (const double offset_m : {i * kShift_m, -i * kShift_m}) {
      const Pose T = moved(T_older_newer, offset_m * shifts.step);
      shifts.T_older_newer.push_back(T);
      shifts.offset_m.push_back(offset_m);
      shifts.num_near.push_back(fitter.fit(pair.surfaces, pair.fitted_newer_m, T, matching).num_near);
    }
  }
  return shifts;
}

}  // namespace swiftlet
