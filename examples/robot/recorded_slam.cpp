// SPDX-License-Identifier: BSD-3-Clause
// SLAM on recordings of a real robot, with core/ only: without simulator and ROS.
//
//   recorded_slam SCANS IMU.csv X Y Z >trajectory.tum
//
// SCANS contains binary PCD files and pcd_index.csv with their stamps; IMU.csv has time, body rate and specific force.
// X Y Z is the position of the LiDAR on the body. Recorders of the simulator write these formats, and so may your
// converter.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "pcd_sweep.hpp"
#include "swiftlet/core/slam/slam.hpp"
#include "swiftlet/core/stage_tables/estimators.hpp"

namespace {

using namespace swiftlet;

struct Sweep {
  std::filesystem::path file;
  TimeNs stamp, duration;
};

/// Cells of the rows of a CSV file with a header line.
std::vector<std::vector<std::string>> read_rows(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.string() + ": expected a CSV file, found none");
  std::vector<std::vector<std::string>> rows;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

std::vector<ImuSample> read_imu(const std::filesystem::path& file) {
  std::vector<ImuSample> samples;
  for (const auto& row : read_rows(file)) {
    const auto number = [&row](std::size_t i) { return std::stod(row.at(i)); };
    samples.push_back({from_seconds(number(0)), {number(1), number(2), number(3)}, {number(4), number(5), number(6)}});
  }
  return samples;
}

std::vector<Sweep> read_index(const std::filesystem::path& folder) {
  std::vector<Sweep> sweeps;
  for (const auto& row : read_rows(folder / "pcd_index.csv")) {
    sweeps.push_back({folder / row.at(0), from_seconds(std::stod(row.at(1))), from_seconds(std::stod(row.at(2)))});
  }
  return sweeps;
}

void write_tum(const StateEstimate& estimate) {
  const Vector3 p_m = estimate.T_local_body.translation();
  const Eigen::Quaterniond q(estimate.T_local_body.linear());
  std::printf("%.9f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n", to_seconds(estimate.t), p_m.x(), p_m.y(), p_m.z(), q.x(),
              q.y(), q.z(), q.w());
}

void run(const std::filesystem::path& scans, const std::filesystem::path& imu_file, const Vector3& lidar_body_m) {
  AgentSetup setup;
  setup.start_known = StartKnown::kNothing;  // the trajectory begins at the origin
  const auto slam = make_estimator(Module(estimator_module_types(), "slam"), setup);
  Outbox outbox;
  const std::vector<Sweep> sweeps = read_index(scans);
  auto sweep = sweeps.begin();
  // One step for each IMU sample. A sweep is delivered when its last beam has been fired.
  for (const ImuSample& sample : read_imu(imu_file)) {
    Observation observation;
    observation.t = sample.t;
    observation.imu.push_back(sample);
    for (; sweep != sweeps.end() && sweep->stamp + sweep->duration <= sample.t; ++sweep) {
      auto scan = std::make_shared<Scan>(read_sweep(sweep->file, sweep->stamp, sweep->duration));
      scan->T_body_lidar.translation() = lidar_body_m;
      observation.scans.push_back(std::move(scan));
    }
    const StateEstimate& estimate = slam->update(observation, outbox);
    if (!observation.scans.empty() && estimate.valid) write_tum(estimate);
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 6) {
    std::fprintf(stderr, "usage: recorded_slam SCANS IMU.csv X Y Z\n");
    return 2;
  }
  run(argv[1], argv[2], {std::atof(argv[3]), std::atof(argv[4]), std::atof(argv[5])});
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "recorded_slam: %s\n", error.what());
  return 1;
}
