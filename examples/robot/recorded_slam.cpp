// SPDX-License-Identifier: BSD-3-Clause
// SLAM on recordings of a real robot, with core/ only: without simulator and ROS.
//
//   recorded_slam SCANS IMU.csv MOUNT.txt >trajectory.tum
//
// SCANS contains PCD files and pcd_index.csv with their stamps; IMU.csv has time, body rate and specific force;
// MOUNT.txt has the pose of the LiDAR in the body frame, in which the IMU measures. Recorders of the simulator write
// these formats, and so may your converter.
#include <cstdio>
#include <string>

#include "pcd_sweep.hpp"
#include "records_file.hpp"
#include "swiftlet/core/slam/slam.hpp"
#include "swiftlet/core/stage_tables/estimators.hpp"

namespace {

using namespace swiftlet;

std::unique_ptr<StateEstimator> make_slam() {
  AgentSetup setup;
  setup.start_known = StartKnown::kNothing;  // the trajectory begins at the origin
  Module slam(estimator_module_types(), "slam");
  slam.as<SlamConfig>().latency_s = 0.0;  // a sweep is matched as soon as it is complete
  return make_estimator(slam, setup);
}

/// Feeds SLAM, writes its trajectory to stdout and its faults and warnings to stderr.
class Recorder {
 public:
  void update(const Observation& observation) {
    const StateEstimate& estimate = slam_->update(observation, outbox_);
    if (!observation.scans.empty() && estimate.valid) write_tum(estimate);
    const std::string note = estimate.valid ? slam_->warning() : slam_->fault();
    if (note != note_ && !note.empty()) std::fprintf(stderr, "%.3f s: %s\n", to_seconds(observation.t), note.c_str());
    note_ = note;
  }

 private:
  static void write_tum(const StateEstimate& estimate) {
    const Vector3 p_m = estimate.T_local_body.translation();
    const Eigen::Quaterniond q(estimate.T_local_body.linear());
    std::printf("%.9f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n", to_seconds(estimate.t), p_m.x(), p_m.y(), p_m.z(), q.x(),
                q.y(), q.z(), q.w());
  }

  std::unique_ptr<StateEstimator> slam_ = make_slam();
  Outbox outbox_;
  std::string note_;
};

void run(const std::filesystem::path& scans, const std::filesystem::path& imu_file, const Pose& T_body_lidar) {
  const std::vector<SweepFile> sweeps = read_index(scans);
  auto sweep = sweeps.begin();
  Recorder recorder;
  Observation observation;
  const auto deliver = [&] {
    const auto& [file, stamp, duration] = *sweep++;
    observation.scans.push_back(std::make_shared<const Scan>(read_sweep(file, stamp, duration, T_body_lidar)));
  };
  // One step for each IMU sample. A sweep is delivered when its last beam has been fired.
  for (const ImuSample& sample : read_imu(imu_file)) {
    observation.clear();
    observation.t = sample.t;
    observation.imu.push_back(sample);
    while (sweep != sweeps.end() && sweep->stamp + sweep->duration <= sample.t) deliver();
    recorder.update(observation);
  }
  // Sweeps that end after the last IMU sample. Without IMU the estimate soon becomes invalid.
  while (sweep != sweeps.end()) {
    observation.clear();
    observation.t = sweep->stamp + sweep->duration;
    deliver();
    recorder.update(observation);
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::fprintf(stderr, "usage: recorded_slam SCANS IMU.csv MOUNT.txt\n");
    return 2;
  }
  run(argv[1], argv[2], read_mount(argv[3]));
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "recorded_slam: %s\n", error.what());
  return 1;
}
