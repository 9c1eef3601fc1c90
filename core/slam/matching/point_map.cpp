// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/point_map.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/slam/matching/matching_limits.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"

namespace swiftlet {
namespace {

// [m] Minimum distance between points of a voxel: kVoxel_m / sqrt(kCapacity), so that kCapacity points cover a plane
// through the voxel evenly. With smaller values, the points of one scan fill the voxel.
constexpr float kSpacing_m = 0.22F;
// [-] Largest number of iterations. More of them cost time.
constexpr int kIterations = 200;
// [-] Largest distance of a pair, in widths of the kernel; its weight there is 1 %. Larger values add distant pairs,
// most of which are wrong.
constexpr double kReach_widths = 3.0;

std::int64_t index_of(double x) { return static_cast<std::int64_t>(std::floor(x / PointMap::kVoxel_m)); }

}  // namespace

void PointMap::insert(std::span<const Vector3> points_local_m) {
  for (const Vector3& p : points_local_m) {
    const std::uint32_t number = table_.find_or_insert(cell_key(index_of(p.x()), index_of(p.y()), index_of(p.z())));
    if (number == voxels_.size()) voxels_.emplace_back();
    Voxel& voxel = voxels_[number];
    if (voxel.count == kCapacity) continue;
    const Eigen::Vector3f point = p.cast<float>();
    bool apart = true;
    for (int i = 0; i < voxel.count && apart; ++i)
      apart = (voxel.points_local_m[i] - point).squaredNorm() > kSpacing_m * kSpacing_m;
    if (apart) voxel.points_local_m[voxel.count++] = point;
  }
}

void PointMap::keep_around(const Vector3& center_local_m, double radius_m) {
  table_.erase_if(voxels_, [&](std::uint64_t, const Voxel& voxel) {
    return (voxel.points_local_m[0].cast<double>() - center_local_m).squaredNorm() > radius_m * radius_m;
  });
}

void PointMap::clear() {
  table_.clear();
  voxels_.clear();
}

const Eigen::Vector3f* PointMap::nearest(const Vector3& p_local_m, double within_m) const {
  const Eigen::Vector3f p = p_local_m.cast<float>();
  const std::int64_t x = index_of(p_local_m.x()), y = index_of(p_local_m.y()), z = index_of(p_local_m.z());
  const Eigen::Vector3f* best = nullptr;
  auto least = static_cast<float>(within_m * within_m);
  for (std::int64_t i = x - 1; i <= x + 1; ++i) {
    for (std::int64_t j = y - 1; j <= y + 1; ++j) {
      for (std::int64_t k = z - 1; k <= z + 1; ++k) {
        const std::uint32_t found = table_.find(cell_key(i, j, k));
        if (found == 0) continue;
        const Voxel& voxel = voxels_[found - 1];
        for (int n = 0; n < voxel.count; ++n) {
          const float square = (voxel.points_local_m[n] - p).squaredNorm();
          if (square >= least) continue;
          least = square;
          best = &voxel.points_local_m[n];
        }
      }
    }
  }
  return best;
}

std::optional<Pose> align_points(const PointMap& map, std::span<const Eigen::Vector3f> points_body_m,
                                 const Pose& T_local_body_guess, double width_m) {
  Pose T = T_local_body_guess;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Matrix6 H = Matrix6::Zero();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    int num_pairs = 0;
    for (const Eigen::Vector3f& point : points_body_m) {
      const Vector3 turned_m = T.linear() * point.cast<double>(), p_m = turned_m + T.translation();
      const Eigen::Vector3f* nearest = map.nearest(p_m, kReach_widths * width_m);
      if (nearest == nullptr) continue;
      ++num_pairs;
      const Vector3 r_m = p_m - nearest->cast<double>();
      const double root = width_m * width_m / (width_m * width_m + r_m.squaredNorm());
      Eigen::Matrix<double, 3, 6> J;
      J << Matrix3::Identity(), -skew_of(turned_m);
      H += root * root * J.transpose() * J;
      g += root * root * J.transpose() * r_m;
    }
    if (num_pairs < kMinReturns) return std::nullopt;
    const Eigen::Matrix<double, 6, 1> step = -H.ldlt().solve(g);
    if (!step.allFinite()) return std::nullopt;
    T = make_pose(T.translation() + step.head<3>(),
                  (rotation_by(step.tail<3>()) * Eigen::Quaterniond(T.linear())).normalized());
    if (step.norm() < kConverged) break;
  }
  return T;
}

}  // namespace swiftlet
