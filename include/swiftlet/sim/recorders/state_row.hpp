// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/fields.hpp"
#include "swiftlet/sim/recording/tick_view.hpp"

namespace swiftlet::sim {

/// A row of the table `state`: truth, the vehicle's estimate (est_*), reference of guidance (ref_*), and all rotors.
void put_state(const VehicleState& state, double clearance_m, const Action& action, int num_rotors, ColumnSink& sink);
/// The row of one vehicle in the current tick.
void put_state(const TickView& tick, VehicleId vehicle, int num_rotors, ColumnSink& sink);

}  // namespace swiftlet::sim
