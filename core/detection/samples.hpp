// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// Input of the detector's clustering: the points of a scan that lie in the map, or the voxels that contain them.
struct Samples {
  std::vector<Eigen::Vector3f> at_local_m;  ///< position of the point, or center of the voxel
  std::vector<std::ptrdiff_t> voxel;        ///< index of the voxel in the map
  std::vector<std::uint32_t> point;         ///< index of the point in the cloud; for a voxel, of its first point
  std::vector<int> weight;                  ///< number of points in the voxel; empty: 1 each

  std::size_t size() const { return at_local_m.size(); }
  int weight_of(std::size_t i) const { return weight.empty() ? 1 : weight[i]; }
  void clear();
  void add(const Eigen::Vector3f& p_local_m, std::ptrdiff_t in_voxel, std::uint32_t of_point);
  /// Copies sample i of another list to the end.
  void add(const Samples& from, std::size_t i);
  /// Overwrites sample `to` with sample `from` of this list, for removing samples in place.
  void move(std::size_t from, std::size_t to);
  void resize(std::size_t count);

  /// Takes each point of the cloud within the map as a sample, as in the paper.
  void take_points(const LocalCloud& cloud, const VoxelGrid& grid);
  /// Replaces the points by the centers of their voxels, weighted by the number of points, as in the released code.
  void thin_to_voxels(const VoxelGrid& grid);

 private:
  // Voxel and point of each sample, for thin_to_voxels(); a member to reuse the memory.
  std::vector<std::pair<std::ptrdiff_t, std::uint32_t>> sorted_;
};

/// Mean of a cluster and its bounding box along the principal axes. Mean and scatter matrix weight a voxel by its
/// number of points.
struct ClusterShape {
  Vector3 centroid_local_m = Vector3::Zero();
  Vector3 box_center_local_m = Vector3::Zero();
  Vector3 extent_m = Vector3::Zero();  ///< edges of the box, along the principal axes
  double diagonal_m() const { return extent_m.norm(); }
};
ClusterShape shape_of(const Samples& samples, std::span<const std::uint32_t> members);

}  // namespace swiftlet
