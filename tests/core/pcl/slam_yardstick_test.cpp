// SPDX-License-Identifier: BSD-3-Clause
// PCL's registrations as yardsticks of SLAM: the same scans of a flight, from scan to scan, and by our own matching.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/slam/matching/local_slam.hpp"
#include "swiftlet/core/pcl/filters.hpp"
#include "swiftlet/core/pcl/registration.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"

namespace swiftlet {
namespace {

/// A chain of motions from scan to scan; each is guessed to be the last one again.
class ScanToScan {
 public:
  using Register = PclRegistration (*)(std::span<const Eigen::Vector3f>, std::span<const Eigen::Vector3f>, const Pose&);
  explicit ScanToScan(Register registration) : register_(registration) {}
  void add(const std::vector<Eigen::Vector3f>& points_body_m) {
    if (!last_body_m_.empty()) {
      motion_ = register_(points_body_m, last_body_m_, motion_).T_target_source;
      T_first_body_ = T_first_body_ * motion_;
    }
    last_body_m_ = points_body_m;
  }
  Vector3 p_first_m() const { return T_first_body_.translation(); }

 private:
  Register register_;
  std::vector<Eigen::Vector3f> last_body_m_;
  Pose motion_ = Pose::Identity(), T_first_body_ = Pose::Identity();
};

std::vector<Eigen::Vector3f> thinned_body_m(const Scan& scan) {
  std::vector<Eigen::Vector3f> points_body_m;
  for (int i = 0; i < scan.size(); ++i) {
    if (scan.hit(i) && scan.range_m[i] > 0.8F)
      points_body_m.emplace_back(scan.T_body_lidar.cast<float>() * scan.point_lidar(i));
  }
  return pcl_voxel_grid(points_body_m, 0.25);
}

TEST(SlamYardstick, DriftsLessThanGicpAndNdt) {
  sim::Scenario scenario = sim::load_scenario(
      std::string(SWIFTLET_SOURCE_DIR) + "/scenarios/hall.yaml",
      {{"vehicles[observer].start.position_m", "[0.2, 0, 2.5]"},
       {"vehicles[observer].agent.guidance", "{type: trajectory, center_m: [-3, 0, 2.5], radius_m: 3.2, speed_mps: 2}"},
       {"vehicles[target].start.position_m", "[4.5, -3.2, 2.5]"},
       {"vehicles[target].agent.guidance", "{type: hover}"}});
  scenario.recorders.clear();
  scenario.snapshots.clear();
  scenario.vehicles[0].sensors[0].as<sim::LidarConfig>().rolling = false;
  scenario.duration_s = 6.0;
  sim::Simulation simulation(sim::validated(scenario), 2);

  const Pose T_world_start = simulation.view().states[0].T_world_body();
  LocalSlam slam(LocalSlamConfig{}, T_world_start, 0.6);
  ScanToScan gicp([](auto source, auto target, const Pose& guess) { return pcl_gicp(source, target, guess); });
  ScanToScan ndt([](auto source, auto target, const Pose& guess) { return pcl_ndt(source, target, guess); });
  Pose T_world_first;
  bool begun = false;
  double slam_off_m = 0.0, gicp_off_m = 0.0, ndt_off_m = 0.0, path_m = 0.0;
  Vector3 last_world_m = T_world_start.translation();
  while (!simulation.finished()) {
    simulation.tick();
    const Pose T_world_body = simulation.view().states[0].T_world_body();
    path_m += (T_world_body.translation() - last_world_m).norm();
    last_world_m = T_world_body.translation();
    for (const ImuSample& sample : simulation.view().observations[0].imu) slam.add(sample);
    for (const auto& labeled : simulation.view().scans[0]) {
      const std::shared_ptr<const Scan> scan(labeled, &labeled->scan);
      slam.add(scan);
      const std::vector<Eigen::Vector3f> points_body_m = thinned_body_m(*scan);
      gicp.add(points_body_m);
      ndt.add(points_body_m);
      const Pose T_world_scan = labeled->truth.T_world_lidar.front() * scan->T_body_lidar.inverse();
      if (!begun) T_world_first = T_world_scan;
      begun = true;
      const Vector3 p_first_m = (T_world_first.inverse() * T_world_scan).translation();
      gicp_off_m = (gicp.p_first_m() - p_first_m).norm();
      ndt_off_m = (ndt.p_first_m() - p_first_m).norm();
      slam_off_m = (slam.filter().T_local_body().translation() - T_world_body.translation()).norm();
    }
  }
  std::printf("after %.1f m: local SLAM %.3f m, GICP %.3f m, NDT %.3f m\n", path_m, slam_off_m, gicp_off_m, ndt_off_m);
  EXPECT_GT(path_m, 8.0);
  EXPECT_LT(slam_off_m, 0.03);
  EXPECT_LT(slam_off_m, 0.5 * gicp_off_m);
  EXPECT_LT(slam_off_m, 0.5 * ndt_off_m);
}

}  // namespace
}  // namespace swiftlet
