// SPDX-License-Identifier: BSD-3-Clause
// Scans as an odometry meets them: PCL's GICP registers each to those before it, and the motion from one sweep to the
// next is taken as constant. It knows nothing of the simulator but points and the times of their beams.
#include <gtest/gtest.h>

#include <cstdio>
#include <deque>
#include <vector>

#include "swiftlet/core/pcl/filters.hpp"
#include "swiftlet/core/pcl/registration.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"

namespace swiftlet {
namespace {

/// The part `share` of a motion, for small turns.
Pose part_of(const Pose& motion, double share) {
  const Eigen::AngleAxisd turn(motion.linear());
  return make_pose(share * motion.translation(),
                   Eigen::Quaterniond(Eigen::AngleAxisd(share * turn.angle(), turn.axis())));
}

class Odometry {
 public:
  explicit Odometry(bool corrects_motion) : corrects_motion_(corrects_motion) {}

  /// The pose of the LiDAR in the middle of this sweep, in the frame of the first one.
  const Pose& add(const Scan& scan) {
    // Each point where the middle of the sweep would have seen it. (To the start, an error of the motion would come
    // back with its sign turned, and stay.)
    std::vector<Eigen::Vector3f> points_m;
    points_m.reserve(static_cast<std::size_t>(scan.size()));
    for (int i = 0; i < scan.size(); ++i) {
      if (!scan.hit(i) || scan.range_m[i] < 1.0F) continue;  // nearer is the own hull
      const double share = scan.beams->column_offset_s[i % scan.cols()] / kPeriod_s - 0.5;
      const Vector3 p_lidar_m = scan.point_lidar(i).cast<double>();
      points_m.push_back((corrects_motion_ ? part_of(motion_, share) * p_lidar_m : p_lidar_m).cast<float>());
    }
    points_m = pcl_voxel_grid(points_m, kLeaf_m);
    Pose T = T_first_lidar_ * motion_;
    if (!seen_first_m_.empty()) {
      std::vector<Eigen::Vector3f> target_first_m;
      for (const auto& sweep : seen_first_m_) target_first_m.insert(target_first_m.end(), sweep.begin(), sweep.end());
      target_first_m = pcl_voxel_grid(target_first_m, 0.7 * kLeaf_m);
      T = pcl_gicp(points_m, target_first_m, T,
                   {.max_correspondence_m = 1.0, .max_iterations = 20, .transformation_epsilon = 1e-5})
              .T_target_source;
      motion_ = T_first_lidar_.inverse() * T;
    }
    T_first_lidar_ = T;
    for (Eigen::Vector3f& p : points_m) p = (T * p.cast<double>()).cast<float>();
    seen_first_m_.push_back(std::move(points_m));
    if (seen_first_m_.size() > kSweeps) seen_first_m_.pop_front();
    return T_first_lidar_;
  }

 private:
  static constexpr double kPeriod_s = 0.1, kLeaf_m = 0.4;
  static constexpr std::size_t kSweeps = 15;
  bool corrects_motion_;
  Pose T_first_lidar_ = Pose::Identity(), motion_ = Pose::Identity();
  std::deque<std::vector<Eigen::Vector3f>> seen_first_m_;  // the last sweeps
};

TEST(PclOdometry, DriftsLittleWithMotionCorrectionAndMuchWithout) {
  const std::string file = SWIFTLET_SOURCE_DIR "/tests/core/pcl/hall_rounds.yaml";
  sim::Simulation simulation(sim::load_scenario(file));
  Odometry corrected(true), frozen(false);
  Pose T_first_world = Pose::Identity();
  Vector3 before_first_m = Vector3::Zero();
  double way_m = 0.0, corrected_off_m = 0.0, frozen_off_m = 0.0;
  int scans = 0;
  while (!simulation.finished()) {
    simulation.tick();
    for (const auto& s : simulation.view().scans[0]) {
      const Pose& T_world_lidar = s->truth.T_world_lidar[s->truth.T_world_lidar.size() / 2];
      if (scans++ == 0) T_first_world = T_world_lidar.inverse();
      const Vector3 p_first_m = (T_first_world * T_world_lidar).translation();
      way_m += (p_first_m - before_first_m).norm();
      before_first_m = p_first_m;
      corrected_off_m = (corrected.add(s->scan).translation() - p_first_m).norm();
      frozen_off_m = (frozen.add(s->scan).translation() - p_first_m).norm();
      if (scans % 20 == 0)
        std::printf("at %5.1f m: %.3f m with, %.3f m without\n", way_m, corrected_off_m, frozen_off_m);
    }
  }
  std::printf("after %.1f m: %.3f m off with motion correction, %.3f m without\n", way_m, corrected_off_m,
              frozen_off_m);
  EXPECT_GT(way_m, 20.0);
  EXPECT_LT(corrected_off_m, 0.1);
  EXPECT_GT(frozen_off_m, 3.0 * corrected_off_m);
}

}  // namespace
}  // namespace swiftlet
