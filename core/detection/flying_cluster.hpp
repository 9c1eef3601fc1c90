// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "core/detection/samples.hpp"
#include "swiftlet/core/base/detection.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"

namespace swiftlet {

/// Cluster that rule B of VoFOD classified as flying [Vrba 2025, sec. III-B].
struct FlyingCluster {
  const LocalCloud& cloud;
  const Samples& samples;
  std::span<const std::uint32_t> members;  ///< indices of samples
  const ClusterShape& shape;
  const VoxelMap& map;
  std::span<const Cell> voxels;                  ///< voxels with samples
  std::span<const std::ptrdiff_t> voxels_index;  ///< indices of `voxels` in the map, ascending
};

/// Detection of a flying cluster: position by eq. (19) [Vrba 2025], confidence, highest reflectivity and covariance.
Detection detection_of(const FlyingCluster& cluster, const VofodConfig& config);

}  // namespace swiftlet
