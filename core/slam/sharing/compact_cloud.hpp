// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/slam/map_sharing_config.hpp"

namespace swiftlet {

/// Encoded part of a compact cloud, small enough for one message and decodable without the other parts. Points are in
/// the frame of their submap (T_local_submap).
struct PackedPoints {
  std::uint16_t num_points = 0;
  std::vector<std::uint8_t> data;
};

/// Selects the points of a submap to send: one per voxel of upright structure, of which whole columns are left out
/// above a limit, and one per larger voxel of all points.
///
/// @param range_max_m  distance from the submap's center above which points are left out
std::vector<Eigen::Vector3f> points_to_share_m(std::span<const Eigen::Vector3f> points_submap_m,
                                               const CompactCloudConfig& config, double range_max_m);

/// Encodes points as an octree of occupied voxels around the origin of the frame, with the position of one point in
/// each voxel. The first point of a voxel is kept; points beyond the octree are dropped.
///
/// @param voxel_m     edge of a voxel
/// @param bits        resolution of the position in a voxel: 2^bits steps per axis
/// @param most_bytes  size limit of a part
std::vector<PackedPoints> pack_points(std::span<const Eigen::Vector3f> points_submap_m, double voxel_m, int bits,
                                      int most_bytes);
/// Decodes a part and appends its points. Returns false, and appends nothing, when the bytes do not have the format of
/// pack_points().
bool unpack_points(std::span<const std::uint8_t> data, int num_points, double voxel_m, int bits,
                   std::vector<Eigen::Vector3f>& points_submap_m);

}  // namespace swiftlet
