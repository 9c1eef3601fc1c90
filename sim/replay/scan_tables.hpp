// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "sim/replay/block.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// Appends two tables of a scan: the directions and ranges of its returns, and true poses of the sensor during the
/// sweep. A scan with more than `most_points` returns is thinned to every n-th row and column of beams, but returns
/// from other vehicles are always kept.
/// @param number  number of earlier scans of this sensor; shifts the kept rows and columns, so that consecutive scans
///                show different beams
/// @return number of returns written
std::size_t append_scan(const LabeledScan& labeled, VehicleId vehicle, std::size_t most_points, std::uint64_t number,
                        ReplayBlock& block);

}  // namespace swiftlet::sim
