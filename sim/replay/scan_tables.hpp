// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "sim/replay/block.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// Appends a scan as angles and ranges at the true poses of its sensor, row by row. With more than `most_points`
/// returns it is thinned to a lattice of beams, shifted in each scan; returns from other vehicles are always kept.
/// @param number  number of earlier scans of this sensor
/// @return number of points written
std::size_t append_scan(const LabeledScan& labeled, VehicleId vehicle, std::size_t most_points, std::uint64_t number,
                        ReplayBlock& block);

}  // namespace swiftlet::sim
