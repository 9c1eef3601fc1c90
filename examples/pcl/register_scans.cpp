// SPDX-License-Identifier: BSD-3-Clause
// Estimates a vehicle's motion between two scans with PCL's registrations and compares it with the simulator's truth.
#include <cstdio>
#include <vector>

#include "swiftlet/core/pcl/filters.hpp"
#include "swiftlet/core/pcl/registration.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"

namespace {

using namespace swiftlet;

struct Keyframe {
  Pose T_world_lidar;
  std::vector<Eigen::Vector3f> points_m;  // frame of the LiDAR
};

Keyframe keyframe_of(const sim::LabeledScan& labeled) {
  Keyframe frame{labeled.truth.T_world_lidar.front(), {}};
  for (int i = 0; i < labeled.scan.size(); ++i) {
    if (labeled.scan.hit(i)) frame.points_m.push_back(labeled.scan.point_lidar(i));
  }
  frame.points_m = pcl_voxel_grid(frame.points_m, 0.2);
  return frame;
}

bool report(const char* name, const PclRegistration& found, const Pose& T_target_source) {
  const double error_m = (found.T_target_source.translation() - T_target_source.translation()).norm();
  std::printf("%s: converged %d, fitness %.4f m^2, %.3f m off\n", name, found.converged, found.fitness_m2, error_m);
  return found.converged && error_m < 0.1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: register_scans SCENARIO\n");
    return 2;
  }
  sim::Simulation simulation(sim::load_scenario(argv[1]));
  std::vector<Keyframe> keyframes;
  while (!simulation.finished()) {
    simulation.tick();
    for (const auto& scan : simulation.view().scans[0]) keyframes.push_back(keyframe_of(*scan));
  }
  // Half a second apart: the displacement is smaller than a cell of the normal distributions transform.
  const Keyframe &target = keyframes.front(), &source = keyframes[5];
  const Pose T_target_source = target.T_world_lidar.inverse() * source.T_world_lidar;
  std::printf("%zu keyframes; the vehicle moved %.2f m\n", keyframes.size(), T_target_source.translation().norm());
  const bool gicp = report("GICP", pcl_gicp(source.points_m, target.points_m, Pose::Identity()), T_target_source);
  const bool ndt = report("NDT", pcl_ndt(source.points_m, target.points_m, Pose::Identity()), T_target_source);
  return gicp && ndt ? 0 : 1;
}
