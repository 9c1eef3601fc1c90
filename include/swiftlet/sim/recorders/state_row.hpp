// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/fields.hpp"
#include "swiftlet/sim/view/tick_view.hpp"

namespace swiftlet::sim {

/// A row of the table `state`: truth, the vehicle's estimate of it (est_*), where guidance wants it (ref_*), and as
/// many rotors as it has.
void put_state(const VehicleState& state, double clearance_m, const Action& action, int num_rotors, ColumnSink& sink);
/// Of a vehicle in this tick.
void put_state(const TickView& tick, VehicleId vehicle, int num_rotors, ColumnSink& sink);

}  // namespace swiftlet::sim
