// SPDX-License-Identifier: BSD-3-Clause
#include "sim/metrics/statistics.hpp"
#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {
namespace {

// Reported metrics:
constexpr MetricDefinition kFlightTime = {
    "flight_time_s", "s",
    "time off the ground and not crashed: a vehicle at rest nearer to a surface than its own radius stands on it"};
constexpr MetricDefinition kPathLength = {"path_length_m", "m",
                                          "length of the true path in flight, summed over ticks; world frame"};
constexpr MetricDefinition kMeanSpeed = {"mean_speed_mps", "m/s", "path_length_m / flight_time_s; 0 without flight"};
constexpr MetricDefinition kMaxSpeed = {"max_speed_mps", "m/s",
                                        "greatest true speed in any tick in flight; world frame"};
constexpr MetricDefinition kMaxAcceleration = {
    "max_acceleration_mps2", "m/s^2",
    "greatest change of the true velocity over a tick in flight, divided by the tick; world frame, without gravity"};
constexpr MetricDefinition kMotionDefinitions[] = {kFlightTime, kPathLength, kMeanSpeed, kMaxSpeed, kMaxAcceleration};

/// True motion during flight. Accelerations are averaged over a tick.
class MotionMetric final : public Metric {
 public:
  explicit MotionMetric(const MetricSetup& setup) : Metric(setup), vehicles_(num_vehicles()) {}

  void update(const TickView& tick, const MetricContext& context) override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      Vehicle& vehicle = vehicles_[i];
      const VehicleState& state = tick.states[i];
      if (context.flying[i]) {
        vehicle.flight_time_s += context.dt_s;
        vehicle.max_speed_mps = std::max(vehicle.max_speed_mps, state.v_world_mps.norm());
        if (vehicle.known && context.dt_s > 0.0) {
          vehicle.path_length_m += (state.p_world_m - vehicle.p_world_last_m).norm();
          vehicle.max_acceleration_mps2 = std::max(
              vehicle.max_acceleration_mps2, (state.v_world_mps - vehicle.v_world_last_mps).norm() / context.dt_s);
        }
      }
      vehicle.known = true;
      vehicle.p_world_last_m = state.p_world_m;
      vehicle.v_world_last_mps = state.v_world_mps;
    }
  }

  void report(MetricTable& table) const override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      const Vehicle& vehicle = vehicles_[i];
      const bool flew = vehicle.flight_time_s > 0.0;
      table.add(kFlightTime, name_of(i), vehicle.flight_time_s);
      table.add(kPathLength, name_of(i), vehicle.path_length_m);
      table.add(kMeanSpeed, name_of(i), flew ? vehicle.path_length_m / vehicle.flight_time_s : 0.0);
      table.add(kMaxSpeed, name_of(i), vehicle.max_speed_mps);
      table.add(kMaxAcceleration, name_of(i), vehicle.max_acceleration_mps2);
    }
  }

 private:
  struct Vehicle {
    bool known = false;  // a last state is stored
    Vector3 p_world_last_m = Vector3::Zero();
    Vector3 v_world_last_mps = Vector3::Zero();
    double flight_time_s = 0.0;
    double path_length_m = 0.0;
    double max_speed_mps = 0.0;
    double max_acceleration_mps2 = 0.0;
  };

  std::vector<Vehicle> vehicles_;
};

}  // namespace

MetricType motion_metric() {
  return {"motion", "path length, speeds, accelerations, time of flight", make_metric<MotionMetric>,
          kMotionDefinitions};
}

}  // namespace swiftlet::sim
