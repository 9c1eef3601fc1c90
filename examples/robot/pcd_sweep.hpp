// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "swiftlet/core/base/scan.hpp"

/// Reads a sweep of a LiDAR from a PCD file with the fields x, y and z [m] (frame of the LiDAR), and the time of each
/// point in the first field of t, time, timestamp and offset_time: [ns] where it is a whole number, [s] otherwise,
/// after the start of the sweep or of the clock of `stamp`. Times are needed unless the duration is 0. Other fields are
/// ignored. Every point becomes a beam. Throws std::runtime_error with the file's name.
swiftlet::Scan read_sweep(const std::filesystem::path& file, swiftlet::TimeNs stamp, swiftlet::TimeNs duration,
                          const swiftlet::Pose& T_body_lidar);
