// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/grid_matcher.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "core/slam/matching/matching_limits.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// [-] Share of the cells in the variance of a scan's evidence: scans that meet the same cells share their errors.
// Larger values report a larger covariance.
constexpr double kMapShare = 0.5;
// [-] Least probability of a cell that counts as a surface. Larger values compare start velocities by fewer points.
constexpr double kSurface = 0.5;
// [-] Scatter in directions without evidence, as a share of the trace. Larger values weigh scans less.
constexpr double kTinyScatter = 1e-12;
// [m] Edge of the cubes that contribute one point each to the planes for the test of open directions. Smaller cubes
// keep more detail and cost time.
constexpr float kPlanesVoxel_m = 0.3F;
// [-] Least number of points on free-standing structure; gaps between scan lines look like it. Smaller values overlook
// open directions.
constexpr int kTestedStanding = 30;
// [-] Least share of the planes' information: normals are no better than the poses. Smaller values overlook open
// directions.
constexpr double kTestedShare = 0.01;
// [scans] Length of a map of planes, which takes at most twice as many; a test needs half. Larger values test against
// planes that the drift has bent.
constexpr int kPlanesScans = 10;

SurfaceMapConfig last_planes() {
  SurfaceMapConfig config;
  config.levels = 3;
  config.plane_sigma_m = 0.1;  // includes errors of the scans' poses
  return config;
}

}  // namespace

GridMatcher::GridMatcher(const GridMatchingConfig& config)
    : config_(config), submaps_(config.submaps), planes_(2, Planes{SurfaceMap(last_planes())}) {}

ScanMatcher::Admission GridMatcher::admission() const {
  return {0, config_.insert_after_m, config_.insert_after_deg * kRadPerDeg, config_.insert_after_s};
}

void GridMatcher::take(std::span<const Eigen::Vector3f> returns_body_m, bool) {
  const auto least_sq = static_cast<float>(config_.range_min_m * config_.range_min_m);
  const auto most_sq = static_cast<float>(config_.range_max_m * config_.range_max_m);
  in_range_body_m_.clear();
  for (const Eigen::Vector3f& p : returns_body_m) {
    const float range_sq = p.squaredNorm();
    if (range_sq >= least_sq && range_sq <= most_sq) in_range_body_m_.push_back(p);
  }
  thinner_.thin_into(in_range_body_m_, static_cast<float>(config_.voxel_m), dense_body_m_);
  filter_.thin(dense_body_m_, config_.high, high_body_m_);
  filter_.thin(dense_body_m_, config_.low, low_body_m_);
  thinner_.thin_into(dense_body_m_, kPlanesVoxel_m, planes_body_m_);
  thinner_.thin_into(planes_body_m_, kMatchVoxel_m, tested_body_m_);
}

ScanMatcher::Match GridMatcher::match(InertialFilter& filter, const Uncertainty& uncertainty) {
  const GridSubmap& submap = submaps_.older();
  const GridsMatch found = match_to_grids({GridCloud{&submap.high, high_body_m_, config_.cost.high_weight},
                                           GridCloud{&submap.low, low_body_m_, config_.cost.low_weight}},
                                          submap.origin_local_m, filter.T_local_body(), config_.cost);
  Match match;
  match.num_iterations = std::max(found.num_iterations, 1);
  ScanFit& fit = match.fit;
  count_known(fit, found.T_local_body);
  fit.map_share = kMapShare;
  fit.renewal = 1.0 / std::min(submap.num_scans + 1, config_.submaps.scans);
  fit.num_degenerate = count_open(found.T_local_body, uncertainty.range_sigma_m);
  if (fit.num_known < uncertainty.known_share_min * fit.num_points) return match;

  InertialFilter::WeighedPose pose;
  pose.slope = found.evidence.H;
  pose.scatter = config_.points_per_error * found.evidence.scatter +
                 uncertainty.smear_m * uncertainty.smear_m * pose.slope.leftCols<3>() * pose.slope.topRows<3>();
  pose.scatter.diagonal().array() += kTinyScatter * pose.scatter.trace();
  const Matrix6 whole = pose.slope + Matrix6(found.held.asDiagonal());
  pose.gain = whole.inverse();
  pose.moved = found.moved;
  pose.contribution = whole * pose.moved;
  filter.set_scan_motion(Eigen::Matrix<double, 6, 1>::Zero());  // these weights do not cover the time offset
  filter.take(pose);
  fit.evidence.information = pose.slope * pose.scatter.partialPivLu().solve(pose.slope);
  return match;
}

/// Number of directions of the pose that the planes of the last scans leave open.
int GridMatcher::count_open(const Pose& T_local_body, double range_sigma_m) {
  const Planes& planes = planes_[older_planes_];
  if (planes.num_scans < kPlanesScans / 2) return 0;
  ScanToMapConfig config;
  config.standing_points = kTestedStanding;
  config.degenerate_share = kTestedShare;
  return fitter_.fit(planes.map, tested_body_m_, T_local_body, config, 0.0, range_sigma_m).num_degenerate;
}

void GridMatcher::count_known(ScanFit& fit, const Pose& T_local_body) const {
  const GridSubmap& submap = submaps_.older();
  fit.num_points = static_cast<int>(low_body_m_.size());
  for (const Eigen::Vector3f& point : low_body_m_) {
    const Vector3 at_m = T_local_body * point.cast<double>() - submap.origin_local_m;
    const std::uint16_t value = submap.low.value(submap.low.cell_at(at_m));
    fit.num_known += value != grid_value::kUnknown;
    fit.num_near += grid_value::probability_of(value) >= kSurface;
  }
}

void GridMatcher::insert(const Pose& T_local_body) {
  points_local_m_.resize(dense_body_m_.size());
  for (std::size_t i = 0; i < dense_body_m_.size(); ++i)
    points_local_m_[i] = T_local_body * dense_body_m_[i].cast<double>();
  submaps_.insert(points_local_m_, T_local_body.translation());
  learn_planes(T_local_body);
}

void GridMatcher::learn_planes(const Pose& T_local_body) {
  if (planes_[1 - older_planes_].num_scans >= kPlanesScans) {
    planes_[older_planes_].map.clear();
    planes_[older_planes_].num_scans = 0;
    older_planes_ = 1 - older_planes_;
  }
  points_local_m_.resize(planes_body_m_.size());
  for (std::size_t i = 0; i < planes_body_m_.size(); ++i)
    points_local_m_[i] = T_local_body * planes_body_m_[i].cast<double>();
  for (Planes* planes : {&planes_[older_planes_], &planes_[1 - older_planes_]}) {
    if (planes == &planes_[1 - older_planes_] && planes_[older_planes_].num_scans <= kPlanesScans) continue;
    planes->map.insert(points_local_m_, T_local_body.translation());
    ++planes->num_scans;
  }
}

void GridMatcher::clear() {
  submaps_.clear();
  for (Planes& planes : planes_) {
    planes.map.clear();
    planes.num_scans = 0;
  }
}

void GridMatchingConfig::visit(ConfigVisitor& v) {
  v.field("range_min_m", range_min_m, "[m] range below which returns are ignored", Range::non_negative());
  v.field("range_max_m", range_max_m, "[m] range above which returns are ignored", Range::between(1.0, 1000.0));
  v.object("submaps", submaps, "alternating pairs of grids into which scans are inserted");
}

}  // namespace swiftlet
