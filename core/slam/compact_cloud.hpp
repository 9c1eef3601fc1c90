// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/frames.hpp"
#include "swiftlet/core/slam/map_sharing_config.hpp"

namespace swiftlet {

/// A part of a compact cloud that can be read alone. Clouds are in the frames of their submaps, as T_local_submap tells
/// them.
struct PackedPoints {
  std::uint16_t num_points = 0;
  std::vector<std::uint8_t> data;
};

/// The points of a submap that are worth sending: one in each voxel of what stands upright, and fewer of the ground.
std::vector<Eigen::Vector3f> points_to_share_m(std::span<const Eigen::Vector3f> points_submap_m,
                                               const CompactCloudConfig& config);

/// An octree over voxels around the origin of the frame, and the place of each voxel's point within it. Of points that
/// share a voxel the first is kept; what lies beyond the octree is left out.
///
/// @param most_bytes  of each part
std::vector<PackedPoints> pack_points(std::span<const Eigen::Vector3f> points_submap_m, double voxel_m, int bits,
                                      int most_bytes);
/// Appends the points of a part. False, and nothing is appended, when the bytes are not what pack_points() makes.
bool unpack_points(std::span<const std::uint8_t> data, int num_points, double voxel_m, int bits,
                   std::vector<Eigen::Vector3f>& points_submap_m);

}  // namespace swiftlet
