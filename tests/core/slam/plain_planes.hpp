// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "swiftlet/core/slam/surface_map.hpp"

namespace swiftlet::testing {

/// Points of a scan that meet one plane of the map, as offsets from its cell's mean, each with its own information.
struct PlainPlane {
  const SurfaceCell* cell = nullptr;
  std::vector<Vector3> off_m;
  std::vector<double> information;

  /// Offset and slopes along axis and aside, as each point meets them.
  Eigen::MatrixX3d regressors() const {
    Eigen::MatrixX3d A(off_m.size(), 3);
    for (std::size_t i = 0; i < off_m.size(); ++i)
      A.row(i) << 1.0, cell->axis.cast<double>().dot(off_m[i]), cell->aside().cast<double>().dot(off_m[i]);
    return A;
  }
  /// Variances of the map's plane, by least squares through n points; scatter beyond the ranges' noise stays in full.
  Vector3 variances(double floor_m2, double range_sigma_m, const Vector3& p_sensor_m) const {
    const Vector3 beam = (cell->mean_m.cast<double>() - p_sensor_m).normalized();
    const double n = cell->count_fitted, of_point = std::min(floor_m2, 1e-4) + cell->variance_m2;
    const double noise = std::pow(range_sigma_m * beam.dot(cell->normal.cast<double>()), 2);
    const double structure = cell->variance_m2 - noise * (1.0 + std::sqrt(8.0 / n));
    return {of_point / n + std::max(structure, 0.0), of_point / n / cell->wide_variance_m2,
            of_point / n / cell->narrow_variance_m2};
  }
  /// Covariance of all distances together: each point has its own noise, the plane's error is common to all.
  Eigen::MatrixXd covariance(const Vector3& variances) const {
    const Eigen::MatrixX3d A = regressors();
    Eigen::MatrixXd S = A * variances.asDiagonal() * A.transpose();
    for (std::size_t i = 0; i < information.size(); ++i) S(i, i) += 1.0 / information[i];
    return S;
  }
};

/// In the order in which points meet the cells, so that sums are reproducible.
class PlainPlanes {
 public:
  void add(const SurfaceCell& cell, const Vector3& off_m, double information) {
    const auto [place, is_new] = index_.try_emplace(&cell, planes_.size());
    if (is_new) planes_.push_back({&cell, {}, {}});
    planes_[place->second].off_m.push_back(off_m);
    planes_[place->second].information.push_back(information);
  }
  const std::vector<PlainPlane>& all() const { return planes_; }

 private:
  std::map<const SurfaceCell*, std::size_t> index_;
  std::vector<PlainPlane> planes_;
};

}  // namespace swiftlet::testing
