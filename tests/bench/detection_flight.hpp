// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <omp.h>

#include <cmath>
#include <memory>

#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/world/forest.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "tests/support/sensor_driver.hpp"

/// A flight through a clearing of a forest with two other UAVs, for the benchmarks of detectors.
namespace swiftlet::sim {

inline constexpr TimeNs kFlightStep = 2'000'000;
inline constexpr int kFlyingVehicles = 3;

inline VehicleState state_of(int vehicle, TimeNs t) {
  const double s = to_seconds(t);
  const double radius = vehicle == 0 ? 5.0 : 4.0 + 4.0 * vehicle, speed = vehicle == 0 ? 2.0 : 5.0;
  const double phase = speed / radius * s + 2.0 * vehicle;
  VehicleState state;
  state.t = t;
  state.p_world_m = {radius * std::cos(phase), radius * std::sin(phase), 4.0 + vehicle};
  state.v_world_mps = {-speed * std::sin(phase), speed * std::cos(phase), 0.0};
  state.q_world_body =
      Eigen::AngleAxisd(phase + 0.5 * M_PI, Vector3::UnitZ()) * Eigen::AngleAxisd(0.1, Vector3::UnitY());
  return state;
}

/// Sweeps of a LiDAR as clouds in the world, in sequence.
class Flight {
 public:
  explicit Flight(const LidarConfig& lidar = {}) {
    omp_set_num_threads(1);
    static const auto scene = [] {
      ForestConfig forest;
      forest.size_m = {70.0, 70.0};
      forest.surroundings_m = 0.0;
      forest.detail = 0.5;
      forest.keep_clear.clearings.push_back({{0.0, 0.0}, 14.0});
      return std::make_shared<const Scene>(make_forest(forest, 1));
    }();
    static const auto world = std::make_shared<const StaticScene>(*scene);
    SensorSetup setup = sensor_setup("lidar", 1, kFlyingVehicles, world);
    setup.scene = scene;
    const auto shape = quadrotor_shape();
    setup.vehicle_shapes.assign(kFlyingVehicles, shape);
    lidar_ = make_lidar(lidar, std::move(setup));
    fly_to(0);
  }

  std::shared_ptr<const LocalCloud> next() {
    observation_.clear();
    while (observation_.scans.empty()) {
      fly_to(now_ + kFlightStep);
      lidar_->measure(now_, history_, observation_);
    }
    auto cloud = std::make_shared<LocalCloud>();
    registrar_.make(observation_.scans.front(), *cloud);
    return cloud;
  }

 private:
  void fly_to(TimeNs t) {
    now_ = t;
    for (int v = 0; v < kFlyingVehicles; ++v) history_.push(v, state_of(v, t));
    StateEstimate estimate;
    estimate.t = t;
    estimate.valid = true;
    estimate.T_local_body = state_of(0, t).T_world_body();
    registrar_.push(estimate);
  }

  std::unique_ptr<Sensor> lidar_;
  StateHistory history_{kFlyingVehicles, 200};
  CloudRegistrar registrar_{0.6};
  Observation observation_;
  TimeNs now_ = 0;
};

}  // namespace swiftlet::sim
