// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "sim/replay/block.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// A scan as angles and ranges at the true poses of its sensor, row after row. Where it has more than `most_points`
/// returns, a lattice of beams is taken, another one each time; returns from other vehicles are always kept.
/// @param number  how many scans of this sensor came before
/// @return points written
std::size_t append_scan(const LabeledScan& labeled, VehicleId vehicle, std::size_t most_points, std::uint64_t number,
                        ReplayBlock& block);

}  // namespace swiftlet::sim
