// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/slam/map_sharing_config.hpp"

namespace swiftlet {

/// A part of a compact cloud that can be decoded alone, in the frame of its submap (T_local_submap).
struct PackedPoints {
  std::uint16_t num_points = 0;
  std::vector<std::uint8_t> data;
};

/// The points of a submap that are sent: one per voxel of upright structure, thinned by whole columns, and one per
/// coarser voxel of everything.
std::vector<Eigen::Vector3f> points_to_share_m(std::span<const Eigen::Vector3f> points_submap_m,
                                               const CompactCloudConfig& config);

/// Octree over voxels around the origin of the frame, with the position of each voxel's point inside it. The first
/// point of a voxel is kept; points beyond the octree are dropped.
///
/// @param most_bytes  size limit of a part
std::vector<PackedPoints> pack_points(std::span<const Eigen::Vector3f> points_submap_m, double voxel_m, int bits,
                                      int most_bytes);
/// Appends the points of a part. Returns false, and appends nothing, when the bytes do not have the format of
/// pack_points().
bool unpack_points(std::span<const std::uint8_t> data, int num_points, double voxel_m, int bits,
                   std::vector<Eigen::Vector3f>& points_submap_m);

}  // namespace swiftlet
