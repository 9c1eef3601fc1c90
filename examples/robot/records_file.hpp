// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "swiftlet/core/base/samples.hpp"

/// Text files of a record. Errors are std::runtime_error with file and line.

struct SweepFile {
  std::filesystem::path file;
  swiftlet::TimeNs stamp, duration;
};

/// Sweeps of the folder's pcd_index.csv, with the columns file, start [s] and duration [s], in the order of their
/// starts.
std::vector<SweepFile> read_index(const std::filesystem::path& folder);

/// Samples of a CSV file with a header line and the columns time [s], body rate x, y, z [rad/s] and specific force x,
/// y, z [m/s^2], in the order of their times.
std::vector<swiftlet::ImuSample> read_imu(const std::filesystem::path& file);

/// Pose of the LiDAR in the body frame, T_body_lidar: a 3 x 4 or 4 x 4 matrix [-, m], row by row. "#" begins a comment.
swiftlet::Pose read_mount(const std::filesystem::path& file);
