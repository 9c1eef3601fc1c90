// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/flying_cluster.hpp"

#include <algorithm>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet {
namespace {

// [voxels] Margin around a cluster's box in which the released code computes the confidence. Larger values lower the
// confidence of clusters near background.
constexpr int kConfidenceMargin = 2;

MeasurementNoise noise_of(const VofodConfig& config) {
  MeasurementNoise noise;
  noise.sigma_range_m = config.sigma_range_m;
  noise.sigma_position_m.setConstant(config.sigma_position_m);
  noise.sigma_attitude_rad.setConstant(config.sigma_attitude_rad);
  return noise;
}

// Highest reflectivity of the points of a cluster. A cluster of voxels has all points in its voxels.
double reflectivity(const FlyingCluster& flying, VofodChoices::Clustering clustering) {
  const LocalCloud& cloud = flying.cloud;
  float greatest = 0.0F;
  if (clustering == VofodChoices::Clustering::kPoints) {
    for (const std::uint32_t i : flying.members)
      greatest = std::max(greatest, cloud.reflectivity_of(flying.samples.point[i]));
    return greatest;
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::ptrdiff_t voxel = flying.map.grid().index_of(cloud.points_local_m[i].cast<double>());
    if (!std::binary_search(flying.voxels_index.begin(), flying.voxels_index.end(), voxel)) continue;
    greatest = std::max(greatest, cloud.reflectivity_of(i));
  }
  return greatest;
}

// Free share of the surroundings of the cluster last searched by rule B: exp(-sum(1 - G / g_free) / voxels) over its
// box and a margin, with its own voxels as free. Unspecified in the paper; the released code counts voxels, so that a
// near object with many points per voxel is not more certain than a far one.
double confidence(const FlyingCluster& flying, double g_free) {
  const VoxelGrid& grid = flying.map.grid();
  Cell first = flying.voxels.front(), last = flying.voxels.front();
  for (const Cell& cell : flying.voxels) {
    first = first.cwiseMin(cell);
    last = last.cwiseMax(cell);
  }
  first = (first.array() - kConfidenceMargin).matrix().cwiseMax(grid.min_cell);
  last = (last.array() + kConfidenceMargin).matrix().cwiseMin(grid.min_cell + grid.size - Cell::Ones());
  double sum = 0.0;
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        const std::ptrdiff_t index = grid.index({x, y, z});
        if (std::binary_search(flying.voxels_index.begin(), flying.voxels_index.end(), index)) continue;
        sum += 1.0 - std::clamp(flying.map.value(index) / g_free, 0.0, 1.0);
      }
    }
  }
  return elementary::exp(-sum / static_cast<double>(flying.voxels.size()));
}

Matrix3 covariance(const FlyingCluster& flying, const Vector3& position_local_m, const VofodConfig& config) {
  const Matrix3 constant = config.sigma_m * config.sigma_m * Matrix3::Identity();
  if (config.covariance == DetectionCovariance::kConstant) return constant;
  const Pose& T_local_lidar =
      flying.cloud.T_local_lidar_of_beam(flying.cloud.beam[flying.samples.point[flying.members.front()]]);
  const Vector3 p_lidar = T_local_lidar.inverse() * position_local_m;
  const double range_m = p_lidar.norm();
  if (range_m <= 0.0) return constant;
  return constant + point_covariance(p_lidar / range_m, range_m, T_local_lidar.linear(), noise_of(config).Sigma_w());
}

}  // namespace

Detection detection_of(const FlyingCluster& flying, const VofodConfig& config) {
  const auto& [cloud, samples, members, shape, map, voxels, voxels_index] = flying;
  Detection d;
  std::int64_t offset_sum = 0;
  for (const std::uint32_t i : members) {
    offset_sum += cloud.time_of(samples.point[i]) - cloud.stamp();
    d.num_points += samples.weight_of(i);
  }
  d.t = cloud.stamp() + offset_sum / static_cast<std::int64_t>(members.size());
  d.position_m =
      config.choices.position == VofodChoices::Position::kCentroid ? shape.centroid_local_m : shape.box_center_local_m;
  d.extent_m = shape.extent_m;
  d.covariance = covariance(flying, d.position_m, config);
  d.confidence = confidence(flying, config.map.g_free);
  d.reflectivity = reflectivity(flying, config.choices.clustering);
  return d;
}

}  // namespace swiftlet
