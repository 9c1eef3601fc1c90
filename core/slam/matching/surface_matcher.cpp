// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/surface_matcher.hpp"

#include <cmath>

#include "core/slam/matching/matching_limits.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [scans] Number of first scans that are all inserted, whatever the motion: a single scan has too few points per cell
/// for planes. Smaller values leave cells between the beams without a plane.
constexpr int kFirstScans = 10;
/// [-] Largest number of iterations of the update by a scan. Larger values correct worse predictions and cost time.
constexpr int kUpdates = 5;
/// [m] Displacement after which distant cells are dropped. Smaller values search the map more often.
constexpr double kCropEvery_m = 10.0;
/// [m] Edges of the cubes that contribute one return each to the map and to the coarse alignment. Smaller cubes keep
/// more detail and cost time.
constexpr float kMapVoxel_m = 0.2F, kCoarseVoxel_m = 1.5F;

/// Keeps at most `most` points, evenly spaced in their order.
void thin_to(std::size_t most, std::vector<Eigen::Vector3f>& points_body_m) {
  const std::size_t num = points_body_m.size();
  if (num <= most) return;
  for (std::size_t i = 0; i < most; ++i) points_body_m[i] = points_body_m[i * num / most];
  points_body_m.resize(most);
}

}  // namespace

ScanMatcher::Admission SurfaceMatcher::admission() const {
  return {kFirstScans, config_.insert_after_m, config_.insert_after_deg * kRadPerDeg, config_.insert_after_s};
}

void SurfaceMatcher::take(std::span<const Eigen::Vector3f> returns_body_m, bool first) {
  thinner_.thin_into(returns_body_m, kMapVoxel_m, dense_body_m_);
  thinner_.thin_into(dense_body_m_, kMatchVoxel_m, sparse_body_m_);
  if (!first) thin_to(static_cast<std::size_t>(config_.map_points), dense_body_m_);
  thin_to(static_cast<std::size_t>(config_.match_points), sparse_body_m_);
}

ScanMatcher::Match SurfaceMatcher::match(InertialFilter& filter, const Uncertainty& uncertainty) {
  Match match;
  const double position_sigma_m = std::sqrt(filter.covariance().diagonal().segment<3>(InertialFilter::kP).maxCoeff());
  match.num_iterations = filter.update(
      [&](const Pose& T_local_body) {
        match.fit = fitter_.fit(map_, sparse_body_m_, T_local_body, config_.matching, uncertainty.smear_m,
                                uncertainty.range_sigma_m, position_sigma_m);
        if (match.fit.num_known < uncertainty.known_share_min * match.fit.num_points) match.fit.evidence = {};
        return match.fit.evidence;
      },
      kUpdates);
  return match;
}

std::optional<Pose> SurfaceMatcher::align(const Pose& T_local_body, double width_m) {
  thinner_.thin_into(sparse_body_m_, kCoarseVoxel_m, coarse_body_m_);
  return align_points(points_, coarse_body_m_, T_local_body, width_m);
}

void SurfaceMatcher::insert(const Pose& T_local_body) {
  const auto place = [&](std::span<const Eigen::Vector3f> points_body_m) {
    points_local_m_.resize(points_body_m.size());
    for (std::size_t i = 0; i < points_body_m.size(); ++i)
      points_local_m_[i] = T_local_body * points_body_m[i].cast<double>();
  };
  place(sparse_body_m_);
  points_.insert(points_local_m_);
  place(dense_body_m_);
  map_.insert(points_local_m_, T_local_body.translation());
  if ((T_local_body.translation() - cropped_local_m_).norm() < kCropEvery_m) return;
  cropped_local_m_ = T_local_body.translation();
  map_.keep_around(cropped_local_m_);
  points_.keep_around(cropped_local_m_, config_.map.keep_radius_m);
}

}  // namespace swiftlet
