// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/state_row.hpp"

#include <limits>
#include <string>

namespace swiftlet::sim {
namespace {

/// The table of states has its rotor columns last, and no covariance.
struct StateColumns : Columns {
  using Columns::Columns;
  void array(const char*, const auto&, const char*) {}
  void covariance(const char*, const auto&, const char*) {}
};

}  // namespace

void put_state(const VehicleState& state, double clearance_m, const Action& action, int num_rotors, ColumnSink& sink) {
  StateColumns truth(sink), estimate(sink, "est_");
  VehicleState::visit(state, truth);
  Columns(sink).field("clearance_m", clearance_m, "[m] clearance to the nearest surface or vehicle");
  const WorldEstimate estimate_world = in_world(action.estimate);
  WorldEstimate::visit(estimate_world, estimate);
  put_columns(action.reference, sink, "ref_");
  for (int i = 0; i < num_rotors; ++i) {
    sink.number({{}, "rotor*_radps", std::to_string(i).c_str(), "[rad/s] true speed of each rotor"},
                state.rotor_speed_radps[i]);
  }
}

void put_state(const TickView& tick, VehicleId vehicle, int num_rotors, ColumnSink& sink) {
  static const Action kNone;
  const Action& action = tick.actions[vehicle] ? *tick.actions[vehicle] : kNone;
  const double clearance_m =
      tick.clearance_m.empty() ? std::numeric_limits<double>::quiet_NaN() : tick.clearance_m[vehicle];
  put_state(tick.states[vehicle], clearance_m, action, num_rotors, sink);
}

}  // namespace swiftlet::sim
