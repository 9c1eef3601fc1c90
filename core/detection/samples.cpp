// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/samples.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace swiftlet {

void Samples::clear() {
  at_local_m.clear();
  voxel.clear();
  point.clear();
  weight.clear();
}

void Samples::add(const Eigen::Vector3f& p_local_m, std::ptrdiff_t in_voxel, std::uint32_t of_point) {
  at_local_m.push_back(p_local_m);
  voxel.push_back(in_voxel);
  point.push_back(of_point);
}

void Samples::add(const Samples& from, std::size_t i) {
  add(from.at_local_m[i], from.voxel[i], from.point[i]);
  if (!from.weight.empty()) weight.push_back(from.weight[i]);
}

void Samples::move(std::size_t from, std::size_t to) {
  at_local_m[to] = at_local_m[from];
  voxel[to] = voxel[from];
  point[to] = point[from];
  if (!weight.empty()) weight[to] = weight[from];
}

void Samples::resize(std::size_t count) {
  at_local_m.resize(count);
  voxel.resize(count);
  point.resize(count);
  if (!weight.empty()) weight.resize(count);
}

void Samples::take_points(const LocalCloud& cloud, const VoxelGrid& grid) {
  clear();
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    const std::ptrdiff_t in_voxel = grid.index_of(cloud.points_local_m[i].cast<double>());
    if (in_voxel >= 0) add(cloud.points_local_m[i], in_voxel, i);
  }
}

void Samples::thin_to_voxels(const VoxelGrid& grid) {
  sorted_.clear();
  for (std::uint32_t i = 0; i < voxel.size(); ++i) sorted_.emplace_back(voxel[i], point[i]);
  std::sort(sorted_.begin(), sorted_.end());
  clear();
  for (std::size_t i = 0; i < sorted_.size(); ++i) {
    if (i == 0 || sorted_[i].first != sorted_[i - 1].first) {
      add(grid.center_m(grid.cell(sorted_[i].first)).cast<float>(), sorted_[i].first, sorted_[i].second);
      weight.push_back(0);
    }
    ++weight.back();
  }
}

ClusterShape shape_of(const Samples& samples, std::span<const std::uint32_t> members) {
  ClusterShape shape;
  Vector3 sum = Vector3::Zero();
  double weight = 0.0;
  for (const std::uint32_t i : members) {
    sum += samples.weight_of(i) * samples.at_local_m[i].cast<double>();
    weight += samples.weight_of(i);
  }
  shape.centroid_local_m = sum / weight;
  Matrix3 scatter = Matrix3::Zero();
  for (const std::uint32_t i : members) {
    const Vector3 r = samples.at_local_m[i].cast<double>() - shape.centroid_local_m;
    scatter += samples.weight_of(i) * (r * r.transpose());
  }
  const Matrix3 axes = Eigen::SelfAdjointEigenSolver<Matrix3>(scatter).eigenvectors();
  Eigen::AlignedBox3d box;
  for (const std::uint32_t i : members) {
    box.extend(Vector3(axes.transpose() * (samples.at_local_m[i].cast<double>() - shape.centroid_local_m)));
  }
  shape.box_center_local_m = shape.centroid_local_m + axes * box.center();
  shape.extent_m = box.sizes();
  return shape;
}

}  // namespace swiftlet
