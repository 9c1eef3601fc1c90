// SPDX-License-Identifier: BSD-3-Clause
#include "sim/metrics/statistics.hpp"
#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {
namespace {

/// True motion while flying. Accelerations are means over a tick.
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
      table.add("flight_time_s", name_of(i), vehicle.flight_time_s, "s");
      table.add("path_length_m", name_of(i), vehicle.path_length_m, "m");
      table.add("mean_speed_mps", name_of(i), flew ? vehicle.path_length_m / vehicle.flight_time_s : 0.0, "m/s");
      table.add("max_speed_mps", name_of(i), vehicle.max_speed_mps, "m/s");
      table.add("max_acceleration_mps2", name_of(i), vehicle.max_acceleration_mps2, "m/s^2");
    }
  }

 private:
  struct Vehicle {
    bool known = false;  // is there a last state?
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

std::unique_ptr<Metric> make_motion_metric(const MetricSetup& setup) { return std::make_unique<MotionMetric>(setup); }

}  // namespace swiftlet::sim
