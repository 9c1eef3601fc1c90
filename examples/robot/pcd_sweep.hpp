// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "swiftlet/core/base/scan.hpp"

/// Reads a sweep of a LiDAR from a binary PCD file with the fields x, y, z (float32 or float64, frame of the LiDAR) and
/// t (uint32, [ns] after the start of the sweep). Other fields and padding are ignored. Every point becomes a beam.
/// Throws std::runtime_error with the file's name.
swiftlet::Scan read_sweep(const std::filesystem::path& file, swiftlet::TimeNs stamp, swiftlet::TimeNs duration);
