// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/slam/matching/adaptive_voxel_filter.hpp"
#include "core/slam/matching/grid_match.hpp"
#include "core/slam/matching/grid_submaps.hpp"
#include "core/slam/matching/scan_matcher.hpp"
#include "core/slam/matching/sweep.hpp"
#include "swiftlet/core/slam/grid_matching_config.hpp"

namespace swiftlet {

/// Local SLAM of the document: scans are matched to the older of two submaps of probability grids [Orsulic 2021; Hess
/// 2016]. The pose minimizes the squared residuals of the match. The filter predicts this pose, and corrects velocity
/// and biases by the result.
///
/// Grids also have gradients along walls and floors, between scan lines, so they do not reveal unconstrained
/// directions. These are determined from the planes of the last scans, as in fit_scan(), and reported without a change
/// of the pose.
class GridMatcher : public ScanMatcher {
 public:
  explicit GridMatcher(const GridMatchingConfig& config);

  Admission admission() const override;
  bool is_empty() const override { return submaps_.empty(); }
  void clear() override;
  void take(std::span<const Eigen::Vector3f> returns_body_m, bool first) override;
  int num_points() const override { return static_cast<int>(low_body_m_.size()); }
  std::span<const Eigen::Vector3f> points_body_m() const override { return dense_body_m_; }
  Match match(InertialFilter& filter, const Uncertainty& uncertainty) override;
  void insert(const Pose& T_local_body) override;
  std::size_t bytes() const override { return submaps_.bytes(); }

  const GridSubmaps& submaps() const { return submaps_; }

 private:
  void count_known(ScanFit& fit, const Pose& T_local_body) const;
  int count_open(const Pose& T_local_body, double range_sigma_m);
  void learn_planes(const Pose& T_local_body);

  GridMatchingConfig config_;
  GridSubmaps submaps_;
  VoxelThinner thinner_;
  AdaptiveVoxelFilter filter_;
  // Scratch of one scan.
  std::vector<Eigen::Vector3f> in_range_body_m_, dense_body_m_, high_body_m_, low_body_m_;
  std::vector<Eigen::Vector3f> planes_body_m_, tested_body_m_;
  std::vector<Vector3> points_local_m_;
  // Planes of the last inserted scans, in two overlapping maps that alternate like submaps.
  struct Planes {
    SurfaceMap map;
    int num_scans = 0;
  };
  std::vector<Planes> planes_;
  int older_planes_ = 0;
  ScanFitter fitter_;
};

}  // namespace swiftlet
