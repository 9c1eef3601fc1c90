// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/adaptive_voxel_filter.hpp"

namespace swiftlet {
namespace {

// [-] Smallest edge tried, as a share of edge_max_m. Larger values leave too few points of small clouds.
constexpr double kFinestShare = 0.01;
// [-] Relative width of the bracket at which the bisection ends. Larger values save time and keep more points.
constexpr double kExactEnough = 0.1;

}  // namespace

double AdaptiveVoxelFilter::thin(std::span<const Eigen::Vector3f> points_m, const AdaptiveVoxelConfig& config,
                                 std::vector<Eigen::Vector3f>& kept_m) {
  const auto enough = static_cast<std::size_t>(config.points_min);
  const auto range_sq = static_cast<float>(config.range_max_m * config.range_max_m);
  near_m_.clear();
  for (const Eigen::Vector3f& p_m : points_m) {
    if (p_m.squaredNorm() <= range_sq) near_m_.push_back(p_m);
  }
  if (near_m_.size() <= enough) {
    kept_m = near_m_;
    return 0.0;
  }
  const auto is_enough = [&](double edge_m) {
    thinner_.thin_into(near_m_, static_cast<float>(edge_m), kept_m);
    return kept_m.size() >= enough;
  };
  double wide_m = config.edge_max_m;
  if (is_enough(wide_m)) return wide_m;
  double narrow_m = 0.5 * wide_m;
  while (!is_enough(narrow_m)) {
    if (narrow_m <= kFinestShare * config.edge_max_m) return narrow_m;
    wide_m = narrow_m;
    narrow_m *= 0.5;
  }
  while (wide_m - narrow_m > kExactEnough * narrow_m) {
    const double middle_m = 0.5 * (narrow_m + wide_m);
    (is_enough(middle_m) ? narrow_m : wide_m) = middle_m;
  }
  is_enough(narrow_m);  // the edge tried last may have been too wide
  return narrow_m;
}

}  // namespace swiftlet
