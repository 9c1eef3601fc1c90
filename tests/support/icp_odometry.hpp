// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/base/scan.hpp"

namespace swiftlet::support {

/// Treatment of the times of beams within a sweep.
enum class SweepTimes { kAsFired, kIgnored, kReversed };

/// Reference: the point-to-point odometry of Vizzo et al. (KISS-ICP, RA-L 2023), written from the paper with the
/// defaults of its table. It uses no IMU, no simulator and none of this project's matching.
class IcpOdometry {
 public:
  explicit IcpOdometry(SweepTimes times) : times_(times) {}

  /// The pose of the LiDAR in the middle of the sweep, relative to the middle of the first one.
  Pose add(const Scan& scan) {
    const Pose motion = last_before_.inverse() * last_;
    const std::vector<Eigen::Vector3d> all = corrected(scan, motion);
    const std::vector<Eigen::Vector3d> dense = thinned(all, 0.5 * kVoxel_m);
    const std::vector<Eigen::Vector3d> sparse = thinned(dense, 1.5 * kVoxel_m);
    const Pose predicted = last_ * motion;
    const double sigma_m = threshold_m();
    const Pose found = map_.empty() ? predicted : aligned(sparse, predicted, 3.0 * sigma_m, sigma_m / 3.0);
    if (found.translation().norm() > 5.0 * kMinMotion_m) learn(predicted.inverse() * found);
    insert(dense, found);
    last_before_ = last_;
    last_ = found;
    last_.linear() = Eigen::Quaterniond(found.linear()).normalized().toRotationMatrix();
    return last_;
  }

 private:
  static constexpr double kVoxel_m = 1.0;
  static constexpr double kRangeMax_m = 100.0;
  static constexpr double kRangeMin_m = 0.8;  // nearer returns are the vehicle itself
  static constexpr std::size_t kPointsPerVoxel = 20;
  static constexpr double kFirstThreshold_m = 2.0, kMinMotion_m = 0.1;
  static constexpr int kIterationsMax = 500;
  static constexpr double kConverged = 1e-4;

  static std::uint64_t key_of(const Eigen::Vector3i& cell) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis)
      key = key << 21U | (static_cast<std::uint64_t>(cell[axis] + (1 << 20)) & 0x1FFFFFU);
    return key;
  }
  static Eigen::Vector3i cell_of(const Eigen::Vector3d& p_m, double edge_m) {
    return (p_m / edge_m).array().floor().cast<int>();
  }

  /// Section III-A: points are moved to the middle of the sweep by the motion between the last two scans.
  std::vector<Eigen::Vector3d> corrected(const Scan& scan, const Pose& motion) const {
    const Eigen::AngleAxisd turn(motion.linear());
    const double duration_s = std::max(1e-9, to_seconds(scan.duration));
    std::vector<Eigen::Vector3d> points_m;
    points_m.reserve(scan.size());
    for (int fired = 0; fired < scan.size(); ++fired) {
      const int i = fired % scan.rows() * scan.cols() + fired / scan.rows();
      if (!scan.hit(i) || scan.range_m[i] < kRangeMin_m || scan.range_m[i] > kRangeMax_m) continue;
      double share = scan.beams->offset_s(i) / duration_s - 0.5;
      if (times_ == SweepTimes::kIgnored) share = 0.0;
      if (times_ == SweepTimes::kReversed) share = -share;
      const Eigen::Vector3d p_m = scan.point_lidar(i).cast<double>();
      points_m.emplace_back(Eigen::AngleAxisd(share * turn.angle(), turn.axis()) * p_m + share * motion.translation());
    }
    return points_m;
  }

  /// Section III-B: the first original point of every cell.
  static std::vector<Eigen::Vector3d> thinned(std::span<const Eigen::Vector3d> points_m, double edge_m) {
    std::unordered_map<std::uint64_t, bool> seen;
    std::vector<Eigen::Vector3d> kept_m;
    for (const Eigen::Vector3d& p_m : points_m) {
      if (seen.emplace(key_of(cell_of(p_m, edge_m)), true).second) kept_m.push_back(p_m);
    }
    return kept_m;
  }

  /// Section III-C: past errors of the prediction, as a displacement at the farthest range.
  double threshold_m() const { return num_errors_ == 0 ? kFirstThreshold_m : std::sqrt(sum_sq_m2_ / num_errors_); }
  void learn(const Pose& error) {
    const double angle_rad = Eigen::AngleAxisd(error.linear()).angle();
    const double off_m = error.translation().norm() + 2.0 * kRangeMax_m * std::sin(0.5 * angle_rad);
    if (off_m <= kMinMotion_m) return;
    sum_sq_m2_ += off_m * off_m;
    ++num_errors_;
  }

  const Eigen::Vector3d* nearest(const Eigen::Vector3d& p_m, double reach_m) const {
    const Eigen::Vector3i middle = cell_of(p_m, kVoxel_m);
    const Eigen::Vector3d* best = nullptr;
    double best_sq = reach_m * reach_m;
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          const auto cell = map_.find(key_of(middle + Eigen::Vector3i(x, y, z)));
          if (cell == map_.end()) continue;
          for (const Eigen::Vector3d& q_m : cell->second) {
            const double sq = (q_m - p_m).squaredNorm();
            if (sq < best_sq) best_sq = sq, best = &q_m;
          }
        }
      }
    }
    return best;
  }

  /// Section III-D: point to point, each pair weighted by the kernel of Geman and McClure.
  Pose aligned(std::span<const Eigen::Vector3d> points_m, Pose guess, double reach_m, double kernel_m) const {
    for (int iteration = 0; iteration < kIterationsMax; ++iteration) {
      Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
      Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
      for (const Eigen::Vector3d& point_m : points_m) {
        const Eigen::Vector3d p_m = guess * point_m;
        const Eigen::Vector3d* q_m = nearest(p_m, reach_m);
        if (!q_m) continue;
        const Eigen::Vector3d r_m = p_m - *q_m;
        const double weight = std::pow(kernel_m * kernel_m / (kernel_m * kernel_m + r_m.squaredNorm()), 2);
        Eigen::Matrix<double, 3, 6> J;
        J << Eigen::Matrix3d::Identity(), -skew(p_m);
        H += weight * J.transpose() * J;
        g += weight * J.transpose() * r_m;
      }
      const Eigen::Matrix<double, 6, 1> step = H.ldlt().solve(-g);
      Pose moved = Pose::Identity();
      const double angle_rad = step.tail<3>().norm();
      if (angle_rad > 0.0) moved.linear() = Eigen::AngleAxisd(angle_rad, step.tail<3>() / angle_rad).toRotationMatrix();
      moved.translation() = step.head<3>();
      guess = moved * guess;
      if (step.norm() < kConverged) break;
    }
    return guess;
  }
  static Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
    return (Eigen::Matrix3d() << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0).finished();
  }

  void insert(std::span<const Eigen::Vector3d> points_m, const Pose& at) {
    for (const Eigen::Vector3d& point_m : points_m) {
      const Eigen::Vector3d p_m = at * point_m;
      std::vector<Eigen::Vector3d>& cell = map_[key_of(cell_of(p_m, kVoxel_m))];
      if (cell.size() < kPointsPerVoxel) cell.push_back(p_m);
    }
    std::erase_if(map_, [&at](const auto& cell) {
      return (cell.second.front() - at.translation()).squaredNorm() > kRangeMax_m * kRangeMax_m;
    });
  }

  SweepTimes times_;
  std::unordered_map<std::uint64_t, std::vector<Eigen::Vector3d>> map_;
  Pose last_ = Pose::Identity(), last_before_ = Pose::Identity();
  double sum_sq_m2_ = 0.0;
  int num_errors_ = 0;
};

}  // namespace swiftlet::support
