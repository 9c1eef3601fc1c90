// SPDX-License-Identifier: BSD-3-Clause
// Scans as an odometry meets them: point-to-point ICP against its own map, after KISS-ICP [Vizzo 2023]. It knows
// nothing of the simulator but points and the times of their beams. With its motion correction it drifts little;
// without, much.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <unordered_map>
#include <vector>

#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

std::int64_t key_of(const Vector3& p, double voxel_m) {
  const Eigen::Vector3i c = (p / voxel_m).array().floor().cast<int>();
  return (std::int64_t{c.x()} + 4096) | (std::int64_t{c.y()} + 4096) << 20 | (std::int64_t{c.z()} + 4096) << 40;
}

/// What was seen, in the odometry's own frame: by voxel the plane through its points, if they lie on one.
class PlaneMap {
 public:
  struct Plane {
    Vector3 middle_local_m = Vector3::Zero(), normal_local = Vector3::Zero();
  };

  void add(const Vector3& p_local_m) {
    Voxel& voxel = voxels_[key_of(p_local_m, kVoxel_m)];
    voxel.count += 1.0;
    voxel.sum += p_local_m;
    voxel.products += p_local_m * p_local_m.transpose();
    voxel.is_fresh = false;
  }
  /// Null: no plane here.
  const Plane* at(const Vector3& p_local_m) {
    const auto found = voxels_.find(key_of(p_local_m, kVoxel_m));
    if (found == voxels_.end() || found->second.count < 8.0) return nullptr;
    Voxel& voxel = found->second;
    if (!voxel.is_fresh) fit(voxel);
    return voxel.is_flat ? &voxel.plane : nullptr;
  }

 private:
  static constexpr double kVoxel_m = 0.8;
  struct Voxel {
    double count = 0.0;
    Vector3 sum = Vector3::Zero();
    Matrix3 products = Matrix3::Zero();
    bool is_fresh = false, is_flat = false;
    Plane plane;
  };
  static void fit(Voxel& voxel) {
    voxel.plane.middle_local_m = voxel.sum / voxel.count;
    const Matrix3 covariance =
        voxel.products / voxel.count - voxel.plane.middle_local_m * voxel.plane.middle_local_m.transpose();
    const Eigen::SelfAdjointEigenSolver<Matrix3> axes(covariance);
    voxel.plane.normal_local = axes.eigenvectors().col(0);
    voxel.is_flat = axes.eigenvalues()[0] < 0.0025 && axes.eigenvalues()[1] > 0.01;  // within 5 cm, over 10 cm
    voxel.is_fresh = true;
  }
  std::unordered_map<std::int64_t, Voxel> voxels_;  // looked up only
};

/// The part `share` of a motion, as screw motion does it for small turns.
Pose part_of(const Pose& motion, double share) {
  const Eigen::AngleAxisd turn(motion.linear());
  Pose part = Pose::Identity();
  part.translation() = share * motion.translation();
  part.linear() = Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix();
  return part;
}

std::vector<Vector3> thinned(const std::vector<Vector3>& points, double voxel_m) {
  std::unordered_map<std::int64_t, bool> taken;
  std::vector<Vector3> kept;
  kept.reserve(points.size());
  for (const Vector3& p : points) {
    if (taken.try_emplace(key_of(p, voxel_m), true).second) kept.push_back(p);
  }
  return kept;
}

class Odometry {
 public:
  explicit Odometry(bool corrects_motion) : corrects_motion_(corrects_motion) {}

  /// The pose of the LiDAR at the start of this sweep, in the frame of the first one.
  const Pose& add(const Scan& scan) {
    // Each point where the start of the sweep would have seen it, if the motion is that of the sweep before.
    std::vector<Vector3> points;
    points.reserve(scan.size());
    for (int i = 0; i < scan.size(); ++i) {
      if (!scan.hit(i)) continue;
      const Vector3 p_lidar_m = scan.point_lidar(i).cast<double>();
      if (p_lidar_m.norm() < 1.0) continue;  // the own hull
      const double share = scan.beams->column_offset_s[i % scan.cols()] / kPeriod_s;
      points.push_back(corrects_motion_ ? part_of(motion_, share) * p_lidar_m : p_lidar_m);
    }
    const std::vector<Vector3> for_map = thinned(points, 0.1), source = thinned(for_map, 0.4);
    Pose T = T_first_lidar_ * motion_;
    for (int iteration = 0; is_started_ && iteration < 40; ++iteration) {
      if (register_once(source, T) < 1e-5) break;
    }
    // Else what is not orthogonal would double with every sweep.
    T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
    if (is_started_) motion_ = T_first_lidar_.inverse() * T;
    is_started_ = true;
    T_first_lidar_ = T;
    for (const Vector3& p : for_map) map_.add(T * p);
    return T_first_lidar_;
  }

 private:
  /// One Gauss-Newton step with Geman-McClure weights; how far it moves.
  double register_once(const std::vector<Vector3>& source, Pose& T) {
    constexpr double kKernel_m = 0.1;
    Eigen::Matrix<double, 6, 6> H = 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Vector<double, 6> b = Eigen::Vector<double, 6>::Zero();
    for (const Vector3& p : source) {
      const Vector3 moved = T * p;
      const PlaneMap::Plane* plane = map_.at(moved);
      if (plane == nullptr) continue;
      const double r = plane->normal_local.dot(moved - plane->middle_local_m);
      const double w = std::pow(kKernel_m * kKernel_m / (kKernel_m * kKernel_m + r * r), 2);
      Eigen::Vector<double, 6> J;
      J << plane->normal_local, moved.cross(plane->normal_local);
      H += w * J * J.transpose();
      b += w * r * J;
    }
    const Eigen::Vector<double, 6> step = H.ldlt().solve(-b);
    const Vector3 turn = step.tail<3>();
    Pose change = Pose::Identity();
    if (turn.norm() > 0.0) change.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    change.translation() = step.head<3>();
    T = change * T;
    return step.norm();
  }

  static constexpr double kPeriod_s = 0.1;
  bool corrects_motion_;
  bool is_started_ = false;
  Pose T_first_lidar_ = Pose::Identity(), motion_ = Pose::Identity();
  PlaneMap map_;
};

TEST(ScanOdometry, DriftsLittleWithMotionCorrectionAndMuchWithout) {
  const TemporaryDirectory folder;
  const std::string path = folder.path() / "scenario.yaml";
  write_file(path, R"(
duration_s: 12
world: {type: warehouse}
vehicles:
  - name: uav1
    model: x500
    start: {position_m: [-17.3, -5.68, 3.6], yaw_deg: 0}
    sensors: [{type: lidar, name: os0, model: os0_128, pattern: {columns: 256}, mount: {position_m: [0, 0, 0.12]}}]
    agent:
      localization: {type: ground_truth}
      guidance: {type: waypoints, speed_mps: 4, waypoints_m: [[17.3, -5.68, 3.6], [17.3, 0, 3.6], [-17.3, 0, 3.6]]}
)");
  Simulation simulation(load_scenario(path));
  Odometry corrected(true), frozen(false);
  std::vector<Vector3> true_path_m;
  Pose T_first_world = Pose::Identity();
  double way_m = 0.0, corrected_off_m = 0.0, frozen_off_m = 0.0;
  while (!simulation.finished()) {
    simulation.tick();
    for (const auto& s : simulation.view().scans[0]) {
      const Pose& T_world_lidar = s->truth.T_world_lidar.front();
      if (true_path_m.empty()) T_first_world = T_world_lidar.inverse();
      const Vector3 p_first_m = (T_first_world * T_world_lidar).translation();
      if (!true_path_m.empty()) way_m += (p_first_m - true_path_m.back()).norm();
      true_path_m.push_back(p_first_m);
      corrected_off_m = (corrected.add(s->scan).translation() - p_first_m).norm();
      frozen_off_m = (frozen.add(s->scan).translation() - p_first_m).norm();
    }
  }
  std::printf("after %.1f m: %.3f m off with motion correction, %.3f m without\n", way_m, corrected_off_m,
              frozen_off_m);
  EXPECT_GT(way_m, 25.0);
  EXPECT_LT(corrected_off_m, 0.1);
  EXPECT_GT(frozen_off_m, 3.0 * corrected_off_m);
}

}  // namespace
}  // namespace swiftlet::sim
