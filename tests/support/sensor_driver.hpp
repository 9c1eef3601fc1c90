// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {

/// Prescribed motion of one vehicle: its true state as a function of time [s].
using Motion = std::function<VehicleState(double t_s)>;

/// Shape of a quadrotor for LiDARs: rotors 0.25 m out and 3 cm up.
inline std::shared_ptr<const VehicleShape> quadrotor_shape() {
  Airframe airframe;
  for (int i = 0; i < 4; ++i) {
    const double angle = (0.25 + 0.5 * i) * kPi;
    airframe.rotors.push_back({Vector3(0.25 * std::cos(angle), 0.25 * std::sin(angle), 0.03),
                               i % 2 == 0 ? Rotor::Spin::kCcw : Rotor::Spin::kCw});
  }
  return std::make_shared<const VehicleShape>(make_vehicle_shape(airframe));
}

inline VehicleState state_at(const Vector3& p_world_m, double yaw_rad = 0.0) {
  VehicleState state;
  state.p_world_m = p_world_m;
  state.q_world_body = Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ());
  return state;
}

inline Motion resting(const Vector3& p_world_m, double yaw_rad = 0.0) {
  return [=](double) { return state_at(p_world_m, yaw_rad); };
}

inline Motion straight(const Vector3& p_start_m, const Vector3& v_world_mps, double yaw_rad = 0.0) {
  return [=](double t) {
    VehicleState state = state_at(p_start_m + t * v_world_mps, yaw_rad);
    state.v_world_mps = v_world_mps;
    return state;
  };
}

/// The setup of a sensor called `name` on vehicle 0 ("uav1") among `num_vehicles`.
inline SensorSetup sensor_setup(const std::string& name, std::uint64_t seed = 1, int num_vehicles = 1,
                                std::shared_ptr<const StaticScene> world = nullptr) {
  SensorSetup setup;
  setup.seed = seed;
  setup.name = name;
  setup.entity = "uav1/" + name;
  setup.world = std::move(world);
  for (int i = 0; i < num_vehicles; ++i) {
    auto shape = std::make_shared<VehicleShape>();
    shape->circumscribed_radius_m = 0.5F;
    setup.vehicle_shapes.push_back(shape);
    setup.vehicle_names.push_back("uav" + std::to_string(i + 1));
  }
  return setup;
}

struct DriveOptions {
  double duration_s = 1.0;
  TimeNs tick = 4'000'000;
  TimeNs step = 1'000'000;  ///< interval of true states
  int capacity = 512;
};

/// Runs a sensor on prescribed motions, tick by tick; `on_tick(now, delivered in this tick)`. Returns all samples.
inline Observation drive(Sensor& sensor, const std::vector<Motion>& motions, const DriveOptions& options,
                         const std::function<void(TimeNs, const Observation&)>& on_tick = {}) {
  StateHistory history(static_cast<int>(motions.size()), options.capacity);
  const auto push = [&](TimeNs t) {
    for (std::size_t i = 0; i < motions.size(); ++i) {
      VehicleState state = motions[i](to_seconds(t));
      state.t = t;
      history.push(static_cast<VehicleId>(i), state);
    }
  };
  Observation all, delivered;
  push(0);
  for (TimeNs now = options.tick; now <= from_seconds(options.duration_s); now += options.tick) {
    for (TimeNs t = now - options.tick + options.step; t <= now; t += options.step) push(t);
    delivered.clear();
    sensor.measure(now, history, delivered);
    if (on_tick) on_tick(now, delivered);
    Observation::each_samples(all, [&]<class Sample>(std::vector<Sample>& samples) {
      const auto& some = samples_of<Sample>(delivered);
      samples.insert(samples.end(), some.begin(), some.end());
    });
  }
  return all;
}

}  // namespace swiftlet::sim
