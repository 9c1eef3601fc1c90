// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/pcl/registration.hpp"

#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/ndt.h>

#include "core/pcl/clouds.hpp"

namespace swiftlet {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

// Fewest points that determine a pose.
constexpr std::size_t kMinPoints = 6;

Cloud::Ptr finite_cloud(std::span<const Eigen::Vector3f> points_m) {
  auto cloud = std::make_shared<Cloud>();
  for (const Eigen::Vector3f& p : points_m) {
    if (p.allFinite()) cloud->push_back({p.x(), p.y(), p.z()});
  }
  return cloud;
}

/// Normalizes the rotation of PCL's single-precision pose.
Pose pose_of(const Eigen::Matrix4f& matrix) {
  const Eigen::Matrix4d m = matrix.cast<double>();
  return make_pose(m.topRightCorner<3, 1>(), Eigen::Quaterniond(Matrix3(m.topLeftCorner<3, 3>())).normalized());
}

template <class Method>
PclRegistration align(Method& method, std::span<const Eigen::Vector3f> p_source_m,
                      std::span<const Eigen::Vector3f> p_target_m, const Pose& T_target_source_guess,
                      std::size_t least_points) {
  const Cloud::Ptr source = finite_cloud(p_source_m), target = finite_cloud(p_target_m);
  if (std::min(source->size(), target->size()) < least_points) return {.T_target_source = T_target_source_guess};
  method.setInputSource(source);
  method.setInputTarget(target);
  Cloud aligned;
  method.align(aligned, T_target_source_guess.matrix().cast<float>());
  return {pose_of(method.getFinalTransformation()), method.getFitnessScore(), method.hasConverged()};
}

}  // namespace

PclRegistration pcl_gicp(std::span<const Eigen::Vector3f> p_source_m, std::span<const Eigen::Vector3f> p_target_m,
                         const Pose& T_target_source_guess, const PclGicpSettings& settings) {
  pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
  gicp.setMaxCorrespondenceDistance(settings.max_correspondence_m);
  gicp.setCorrespondenceRandomness(settings.num_neighbors);
  gicp.setMaximumIterations(settings.max_iterations);
  gicp.setTransformationEpsilon(settings.transformation_epsilon);
  const auto neighbors = static_cast<std::size_t>(std::max(settings.num_neighbors, 0));
  return align(gicp, p_source_m, p_target_m, T_target_source_guess, std::max(kMinPoints, neighbors));
}

PclRegistration pcl_ndt(std::span<const Eigen::Vector3f> p_source_m, std::span<const Eigen::Vector3f> p_target_m,
                        const Pose& T_target_source_guess, const PclNdtSettings& settings) {
  pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> ndt;
  ndt.setResolution(static_cast<float>(settings.resolution_m));
  ndt.setStepSize(settings.step_max_m);
  ndt.setOulierRatio(settings.outlier_ratio);
  ndt.setMaximumIterations(settings.max_iterations);
  ndt.setTransformationEpsilon(settings.transformation_epsilon);
  return align(ndt, p_source_m, p_target_m, T_target_source_guess, kMinPoints);
}

}  // namespace swiftlet
