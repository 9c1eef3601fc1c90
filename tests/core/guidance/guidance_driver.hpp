// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"

namespace swiftlet::testing {

/// Velocity of at most 1 m/s toward a goal, which is not passed within a tick.
inline Vector3 velocity_toward(const Vector3& goal_m, const Vector3& from_m, double tick_s) {
  const Vector3 to_m = goal_m - from_m;
  return to_m.norm() < tick_s ? Vector3(to_m / tick_s) : Vector3(to_m.normalized());
}

/// One guidance, stepped tick by tick for a vehicle whose state the test sets.
class GuidanceDriver {
 public:
  template <class Config>
  GuidanceDriver(const char* type, const Config& config, const Vector3& start_m, double yaw_rad = 0.0,
                 const MotionLimits& motion_limits = {})
      : limits(motion_limits) {
    setup.T_local_body_start = pose(start_m, yaw_rad);
    setup.num_vehicles = 8;
    for (int i = 1; i <= setup.num_vehicles; ++i) setup.vehicle_names.push_back("uav" + std::to_string(i));
    make(type, config);
    estimate.valid = true;
    put(start_m, yaw_rad);
  }

  /// Makes the guidance anew with the present `setup`.
  template <class Config>
  void make(const char* type, const Config& config) {
    Module module(guidance_module_types(), type);
    module.as<Config>() = config;
    guidance = make_guidance(module, {setup, limits});
  }

  static Pose pose(const Vector3& p_m, double yaw_rad) {
    return make_pose(p_m, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ())));
  }
  void put(const Vector3& p_m, double yaw_rad = 0.0) { estimate.T_local_body = pose(p_m, yaw_rad); }
  Vector3 p_m() const { return estimate.T_local_body.translation(); }

  /// Moves the vehicle to its goal in one tick.
  void follow(double yaw_rad = 0.0) {
    estimate.v_local_mps = (out.goal.position_m - p_m()) / dt_s;
    put(out.goal.position_m, yaw_rad);
  }
  /// Moves the vehicle toward its goal at 1 m/s, without inertia.
  void approach() {
    estimate.v_local_mps = velocity_toward(out.goal.position_m, p_m(), dt_s);
    put(p_m() + dt_s * estimate.v_local_mps);
  }

  /// Adds an ideal sensor's measurement of another vehicle in this tick, or one with the given covariance.
  void sees(VehicleId id, const Vector3& other_m, const Matrix3& covariance_body = 1e-8 * Matrix3::Identity()) {
    NeighborSample sample;
    sample.t = observation.t + from_seconds(dt_s);
    sample.id = id;
    sample.p_body_m = estimate.T_local_body.inverse() * other_m;
    sample.covariance_body = covariance_body;
    observation.neighbors.push_back(sample);
  }

  const GuidanceOutput& step() {
    begin_tick();
    return end_tick();
  }
  void begin_tick() {
    observation.t += from_seconds(dt_s);
    estimate.t = observation.t;
    poses.push(estimate);
  }
  const GuidanceOutput& end_tick() {
    guidance->step({.dt_s = dt_s,
                    .estimate = estimate,
                    .observation = observation,
                    .poses = poses,
                    .tracks = tracks,
                    .relatives = relatives,
                    .map = map},
                   out, outbox);
    observation.neighbors.clear();
    observation.messages.clear();
    return out;
  }

  /// Counter of a setting; the first counter when none is named.
  Counter counter(const std::string& setting = {}) const {
    std::vector<Counter> counters;
    guidance->append_counters(counters);
    for (const Counter& counter : counters) {
      if (setting.empty() || counter.setting == setting) return counter;
    }
    ADD_FAILURE() << "no counter of setting \"" << setting << '"';
    return {};
  }

  double dt_s = 0.1;
  MotionLimits limits;
  AgentSetup setup;
  std::unique_ptr<Guidance> guidance;
  StateEstimate estimate;
  Observation observation;
  LocalPoses poses;
  std::vector<Track> tracks;
  std::vector<RelativeEstimate> relatives;
  const OccupancyView* map = nullptr;
  GuidanceOutput out;
  Outbox outbox;
};

}  // namespace swiftlet::testing
