// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/interception/intercept.hpp"
#include "swiftlet/core/stages/guidances.hpp"

namespace swiftlet::testing {

inline const MotionLimits kFast{8.0, 4.0, 60.0, 4.0, 2.0, 60.0, 2.0, 2.0};

/// A vehicle that follows its reference exactly, and tracks given by the tests as a function of time.
class Hunt {
 public:
  explicit Hunt(const InterceptConfig& config, const Vector3& start_m, VehicleId self = 0, int num_vehicles = 2) {
    setup_.T_local_body_start = make_pose(start_m, Eigen::Quaterniond::Identity());
    setup_.self = self;
    setup_.vehicle_names = {"interceptor", "target"};
    setup_.num_vehicles = num_vehicles;
    Module module(guidance_module_types(), "intercept");
    module.as<InterceptConfig>() = config;
    guidance = make_guidance(module, {setup_, kFast});
    estimate_.valid = true;
    estimate_.T_local_body = setup_.T_local_body_start;
  }

  /// @param before_tick  sets tracks and received messages
  void run(double duration_s, const std::function<void(double t_s, Hunt&)>& before_tick) {
    const TimeNs end = observation_.t + from_seconds(duration_s);
    while (observation_.t < end) {
      observation_.t += kTick;
      estimate_.t = observation_.t;
      poses_.push(estimate_);
      before_tick(to_seconds(observation_.t), *this);
      guidance->step({.dt_s = to_seconds(kTick),
                      .estimate = estimate_,
                      .observation = observation_,
                      .poses = poses_,
                      .tracks = tracks,
                      .map = map},
                     out, outbox);
      observation_.messages.clear();
      EXPECT_TRUE(out.goal_is_feasible);
      EXPECT_LE(out.goal.velocity_mps.head<2>().norm(), kFast.horizontal_speed_mps * (1 + 1e-9));
      EXPECT_LE(out.goal.acceleration_mps2.head<2>().norm(), kFast.horizontal_acceleration_mps2 * (1 + 1e-9));
      EXPECT_LE(std::abs(out.goal.acceleration_mps2.z()), kFast.vertical_acceleration_mps2 * (1 + 1e-9));
      estimate_.T_local_body =
          make_pose(out.goal.position_m, Eigen::Quaterniond(Eigen::AngleAxisd(out.goal.yaw_rad, Vector3::UnitZ())));
      estimate_.v_local_mps = out.goal.velocity_mps;
      if (notes.empty() || notes.back() != out.note) notes.emplace_back(out.note);
    }
  }
  void run(double duration_s) {
    run(duration_s, [](double, Hunt&) {});
  }

  /// The only track, as of now.
  void sees(const Vector3& p_m, const Vector3& v_mps, std::uint32_t id = 7) {
    tracks.resize(1);
    tracks[0].id = id;
    tracks[0].t = observation_.t;
    tracks[0].corrected = true;
    tracks[0].position_m = p_m;
    tracks[0].velocity_mps = v_mps;
    tracks[0].covariance = 1e-4 * Eigen::Matrix<double, 9, 9>::Identity();
  }
  /// Another track.
  void sees_also(const Vector3& p_m, const Vector3& v_mps, std::uint32_t id) {
    tracks.push_back(tracks.empty() ? Track{} : tracks.front());
    tracks.back().id = id;
    tracks.back().t = observation_.t;
    tracks.back().corrected = true;
    tracks.back().position_m = p_m;
    tracks.back().velocity_mps = v_mps;
  }
  void hears(const Message& message) { observation_.messages.push_back(message); }
  Vector3 p_m() const { return estimate_.T_local_body.translation(); }
  const Vector3& v_mps() const { return estimate_.v_local_mps; }
  TimeNs now() const { return observation_.t; }
  double now_s() const { return to_seconds(observation_.t); }

  std::unique_ptr<Guidance> guidance;
  std::vector<Track> tracks;
  const OccupancyView* map = nullptr;
  GuidanceOutput out;
  Outbox outbox;
  std::vector<std::string> notes;

 private:
  static constexpr TimeNs kTick = 4'000'000;
  AgentSetup setup_;
  StateEstimate estimate_;
  Observation observation_;
  LocalPoses poses_;
};

/// A circle of 10 m at 4 m/s, at a height of 15 m.
inline void circling(double t_s, Hunt& hunt) {
  const double angle = 0.4 * t_s;
  const Vector3 out(std::cos(angle), std::sin(angle), 0.0), along(-std::sin(angle), std::cos(angle), 0.0);
  hunt.sees(10.0 * out + 15.0 * Vector3::UnitZ(), 4.0 * along);
  hunt.tracks[0].acceleration_mps2 = -1.6 * out;
}

}  // namespace swiftlet::testing
