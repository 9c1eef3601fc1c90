// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/slam/matching/point_map.hpp"
#include "core/slam/matching/scan_matcher.hpp"
#include "core/slam/matching/surface_map.hpp"
#include "core/slam/matching/sweep.hpp"
#include "swiftlet/core/slam/local_slam_config.hpp"

namespace swiftlet {

/// Matches scans to the planes of the map, in one iterated update together with the IMU.
class SurfaceMatcher : public ScanMatcher {
 public:
  explicit SurfaceMatcher(const SurfaceMatchingConfig& config) : config_(config), map_(config.map) {}

  Admission admission() const override;
  bool is_empty() const override { return map_.num_cells() == 0; }
  void clear() override {
    map_.clear();
    points_.clear();
  }
  void take(std::span<const Eigen::Vector3f> returns_body_m, bool first) override;
  int num_points() const override { return static_cast<int>(sparse_body_m_.size()); }
  std::span<const Eigen::Vector3f> points_body_m() const override { return dense_body_m_; }
  Match match(InertialFilter& filter, const Uncertainty& uncertainty) override;
  std::optional<Pose> align(const Pose& T_local_body, double width_m) override;
  void insert(const Pose& T_local_body) override;
  std::size_t bytes() const override { return map_.bytes() + points_.bytes(); }

  const SurfaceMap& map() const { return map_; }

 private:
  SurfaceMatchingConfig config_;
  SurfaceMap map_;
  PointMap points_;
  ScanFitter fitter_;
  Vector3 cropped_local_m_ = Vector3::Zero();  // position at the last removal of distant cells; clear() keeps it
  // Scratch of one scan.
  VoxelThinner thinner_;
  std::vector<Eigen::Vector3f> dense_body_m_, sparse_body_m_, coarse_body_m_;
  std::vector<Vector3> points_local_m_;
};

}  // namespace swiftlet
