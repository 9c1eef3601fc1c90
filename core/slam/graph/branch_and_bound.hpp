// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

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
  Eigen::Vector3i min_ = Eigen::Vector3i::Zero(), size_ = Eigen::Vector3i::Zero();  // box of level 0
  std::vector<std::vector<std::uint8_t>> bits_;
};

/// Search window: headings and displacements relative to the guess, in cells of the pyramid.
struct SearchWindow {
  int xy_cells = 10, z_cells = 2;
  double yaw_rad = 0.0, yaw_step_rad = 0.01;
};

struct GridMatch {
  Pose T_map_cloud = Pose::Identity();
  double score = 0.0;  ///< share of the points in occupied cells
};

struct SearchResult {
  std::optional<GridMatch> best;  ///< none: no score reaches score_min
  std::int64_t num_expanded = 0;
  bool complete = true;  ///< false: the budget ended the search; the best pose may be missed
};

/// Poses excluded from the search: those near a given pose in position and heading.
struct Excluded {
  Pose T_map_cloud = Pose::Identity();
  double distance_m = 0.0;
  double angle_rad = 7.0;  ///< default: larger than any difference of headings, so that only the distance counts
};

/// Displacement and heading in the window with the highest score; for equal scores the first. Branch and bound: exact,
/// unless the budget of expanded nodes ends it.
///
/// @param yaws_allowed  a flag for each heading of the window, ascending; empty: all
SearchResult search_best_pose(const OccupancyPyramid& map, std::span<const Eigen::Vector3f> points_cloud_m,
                              const Pose& T_map_cloud_guess, const SearchWindow& window, double score_min,
                              std::int64_t budget, std::span<const std::uint8_t> yaws_allowed = {},
                              const Excluded* excluded = nullptr);

/// Number of headings of a window, and their offsets.
int num_yaws(const SearchWindow& window);
double yaw_offset_rad(const SearchWindow& window, int i);

/// Histogram of surface directions about the vertical, by slices of height, for comparing headings [Hess et al.,
/// Cartographer].
class RotationalHistogram {
 public:
  /// [-] Buckets over half a turn. More buckets distinguish closer headings and enlarge messages.
  static constexpr int kBuckets = 120;
  explicit RotationalHistogram(std::span<const Eigen::Vector3f> points_cloud_m);
  /// From a received message: shares of the largest bucket in 255ths.
  explicit RotationalHistogram(std::span<const std::uint8_t, kBuckets> quantized);
  std::vector<std::uint8_t> quantized() const;
  /// Cosine similarity of this histogram, rotated by yaw, and another; 1: equal.
  double similarity(const RotationalHistogram& other, double yaw_rad) const;

 private:
  std::array<double, kBuckets> weight_{};
};

}  // namespace swiftlet
