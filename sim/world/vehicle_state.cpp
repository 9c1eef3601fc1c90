// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/vehicle_state.hpp"

#include <algorithm>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet::sim {

VehicleState interpolate(const VehicleState& a, const VehicleState& b, TimeNs t) {
  if (t <= a.t || b.t <= a.t) return a;
  if (t >= b.t) return b;
  const double h = to_seconds(b.t - a.t);
  const double s = to_seconds(t - a.t) / h;

  // Cubic Hermite from positions and velocities at both ends.
  const double s2 = s * s;
  const double s3 = s2 * s;
  VehicleState out = a;
  out.t = t;
  out.p_world_m = (2 * s3 - 3 * s2 + 1) * a.p_world_m + (s3 - 2 * s2 + s) * h * a.v_world_mps +
                  (-2 * s3 + 3 * s2) * b.p_world_m + (s3 - s2) * h * b.v_world_mps;
  out.q_world_body = a.q_world_body.slerp(s, b.q_world_body);
  out.v_world_mps = (1 - s) * a.v_world_mps + s * b.v_world_mps;
  out.omega_body_radps = (1 - s) * a.omega_body_radps + s * b.omega_body_radps;
  for (int i = 0; i < kMaxRotors; ++i) {
    out.rotor_speed_radps[i] = (1 - s) * a.rotor_speed_radps[i] + s * b.rotor_speed_radps[i];
    out.rotor_angle_rad[i] = (1 - s) * a.rotor_angle_rad[i] + s * b.rotor_angle_rad[i];
  }
  return out;
}

StateHistory::StateHistory(int num_vehicles, int capacity)
    : num_vehicles_(num_vehicles),
      capacity_(std::max(capacity, 2)),
      ring_(static_cast<std::size_t>(num_vehicles) * capacity_),
      newest_(num_vehicles, -1),
      count_(num_vehicles, 0) {}

void StateHistory::push(VehicleId vehicle, const VehicleState& state) {
  ENSURE(vehicle >= 0 && vehicle < num_vehicles_, vehicle, num_vehicles_);
  ENSURE(count_[vehicle] == 0 || state.t >= latest(vehicle).t, vehicle, to_seconds(state.t));
  newest_[vehicle] = (newest_[vehicle] + 1) % capacity_;
  count_[vehicle] = std::min(count_[vehicle] + 1, capacity_);
  ring_[static_cast<std::size_t>(vehicle) * capacity_ + newest_[vehicle]] = state;
}

const VehicleState& StateHistory::nth_newest(VehicleId vehicle, int n) const {
  const int column = (newest_[vehicle] - n + capacity_) % capacity_;
  return ring_[static_cast<std::size_t>(vehicle) * capacity_ + column];
}

const VehicleState& StateHistory::latest(VehicleId vehicle) const { return nth_newest(vehicle, 0); }

VehicleState StateHistory::at(VehicleId vehicle, TimeNs t) const {
  ENSURE(vehicle >= 0 && vehicle < num_vehicles_, vehicle, num_vehicles_);
  // Binary search for the newest stored state at or before t; ages count from 0.
  const int count = count_[vehicle];
  if (count == 0) return {};
  if (t >= nth_newest(vehicle, 0).t) return nth_newest(vehicle, 0);
  if (t <= nth_newest(vehicle, count - 1).t) {
    const VehicleState& oldest = nth_newest(vehicle, count - 1);
    // A full history has discarded earlier states, so an earlier time would give a wrong result.
    ENSURE(t == oldest.t || count < capacity_, vehicle, to_seconds(t), to_seconds(oldest.t), capacity_);
    return oldest;
  }
  int newer = 0;
  int older = count - 1;
  while (older - newer > 1) {
    const int middle = (older + newer) / 2;
    (nth_newest(vehicle, middle).t > t ? newer : older) = middle;
  }
  return interpolate(nth_newest(vehicle, older), nth_newest(vehicle, newer), t);
}

}  // namespace swiftlet::sim
