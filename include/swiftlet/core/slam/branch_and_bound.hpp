// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// Occupied cells of a cloud and their maxima over 2^h x 2^h x 2^h cells [Hess et al., ICRA 2016]. Level h of a cell is
/// 1 when any of the cells i .. i + 2^h - 1 along each axis is occupied. Dense within the box of the cloud.
class OccupancyPyramid {
 public:
  OccupancyPyramid(std::span<const Eigen::Vector3f> points_map_m, double cell_m, int levels);

  double cell_m() const { return cell_m_; }
  int levels() const { return static_cast<int>(bits_.size()); }
  bool at(int level, int x, int y, int z) const;

 private:
  double cell_m_;
  Eigen::Vector3i min_ = Eigen::Vector3i::Zero(), size_ = Eigen::Vector3i::Zero();  // of level 0; others reach further
  std::vector<std::vector<std::uint8_t>> bits_;
};

/// Headings and displacements from the estimate among which the best one is sought. In cells of the pyramid.
struct SearchWindow {
  int xy_cells = 10, z_cells = 2;
  double yaw_rad = 0.0, yaw_step_rad = 0.01;
};

struct GridMatch {
  Pose T_map_cloud = Pose::Identity();
  double score = 0.0;  ///< share of the points that lie in occupied cells
};

struct SearchResult {
  std::optional<GridMatch> best;  ///< none: no score reaches the least one
  std::int64_t num_expanded = 0;
  bool complete = true;  ///< false: the budget ended it; the best one may have been missed
};

/// What is not to be found: poses near to this one, whose headings are.
struct Excluded {
  Pose T_map_cloud = Pose::Identity();
  double distance_m = 0.0;
  double angle_rad = 7.0;  ///< more than any two headings differ: all count as near
};

/// The displacement and heading in the window with the highest score; of equal ones the first. Branch and bound:
/// exact, unless the budget of expanded nodes ends it.
///
/// @param yaws_allowed  a flag for each heading of the window, in rising order; empty: all
SearchResult search_best_pose(const OccupancyPyramid& map, std::span<const Eigen::Vector3f> points_cloud_m,
                              const Pose& T_map_cloud_guess, const SearchWindow& window, double score_min,
                              std::int64_t budget, std::span<const std::uint8_t> yaws_allowed = {},
                              const Excluded* excluded = nullptr);

/// How many headings a window has, and which they are.
int num_yaws(const SearchWindow& window);
double yaw_offset_rad(const SearchWindow& window, int i);

/// Directions of surfaces about the vertical, by slices of height: to compare headings [Hess et al., Cartographer].
class RotationalHistogram {
 public:
  static constexpr int kBuckets = 120;  // over half a turn
  explicit RotationalHistogram(std::span<const Eigen::Vector3f> points_cloud_m);
  /// As another vehicle tells it: shares of the largest in 255ths.
  explicit RotationalHistogram(std::span<const std::uint8_t, kBuckets> told);
  std::vector<std::uint8_t> told() const;
  /// Cosine of the angle between this one, turned by yaw, and another: 1 when they agree.
  double similarity(const RotationalHistogram& other, double yaw_rad) const;

 private:
  std::array<double, kBuckets> weight_{};
};

}  // namespace swiftlet
