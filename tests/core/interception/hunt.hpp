// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "swiftlet/core/interception/intercept.hpp"
#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet::testing {

inline const MotionLimits kFast{8.0, 4.0, 60.0, 4.0, 2.0, 60.0, 2.0, 2.0};

/// A vehicle that follows its reference exactly, and tracks given by the tests as a function of time.
class Hunt : public GuidanceDriver {
 public:
  explicit Hunt(const InterceptConfig& config, const Vector3& start_m, VehicleId self = 0, int num_vehicles = 2)
      : GuidanceDriver("intercept", config, start_m, 0.0, kFast) {
    dt_s = 0.004;
    setup.self = self;
    setup.num_vehicles = num_vehicles;
    make("intercept", config);
  }

  /// @param before_tick  sets tracks and received messages
  void run(double duration_s, const std::function<void(double t_s, Hunt&)>& before_tick) {
    const TimeNs end = observation.t + from_seconds(duration_s);
    while (observation.t < end) {
      begin_tick();
      before_tick(now_s(), *this);
      end_tick();
      EXPECT_TRUE(out.goal_is_feasible);
      EXPECT_EQ(out.mission == MissionStatus::kFailed, std::string(out.note).starts_with("gave up"));
      EXPECT_LE(out.goal.velocity_mps.head<2>().norm(), limits.horizontal_speed_mps * (1 + 1e-9));
      EXPECT_LE(out.goal.acceleration_mps2.head<2>().norm(), limits.horizontal_acceleration_mps2 * (1 + 1e-9));
      EXPECT_LE(std::abs(out.goal.acceleration_mps2.z()), limits.vertical_acceleration_mps2 * (1 + 1e-9));
      put(out.goal.position_m, out.goal.yaw_rad);
      estimate.v_local_mps = out.goal.velocity_mps;
      if (notes.empty() || notes.back() != out.note) notes.emplace_back(out.note);
    }
  }
  void run(double duration_s) {
    run(duration_s, [](double, Hunt&) {});
  }

  /// The only track, as of now.
  void sees(const Vector3& p_m, const Vector3& v_mps, std::uint32_t id = 7) {
    tracks.clear();
    sees_also(p_m, v_mps, id);
  }
  /// Another track.
  void sees_also(const Vector3& p_m, const Vector3& v_mps, std::uint32_t id) {
    Track& track = tracks.emplace_back();
    track.id = id;
    track.t = observation.t;
    track.corrected = true;
    track.position_m = p_m;
    track.velocity_mps = v_mps;
    track.covariance = 1e-4 * Eigen::Matrix<double, 9, 9>::Identity();
  }
  void hears(const Message& message) { observation.messages.push_back(message); }
  const Vector3& v_mps() const { return estimate.v_local_mps; }
  TimeNs now() const { return observation.t; }
  double now_s() const { return to_seconds(observation.t); }

  std::vector<std::string> notes;
};

/// A circle of 10 m at 4 m/s, at a height of 15 m.
inline void circling(double t_s, Hunt& hunt) {
  const double angle = 0.4 * t_s;
  const Vector3 out(std::cos(angle), std::sin(angle), 0.0), along(-std::sin(angle), std::cos(angle), 0.0);
  hunt.sees(10.0 * out + 15.0 * Vector3::UnitZ(), 4.0 * along);
  hunt.tracks[0].acceleration_mps2 = -1.6 * out;
}

}  // namespace swiftlet::testing
