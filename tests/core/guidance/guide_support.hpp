// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "swiftlet/core/guidance/guide.hpp"
#include "swiftlet/core/messages/guiding_path.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "tests/core/guidance/guidance_driver.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet::testing {

inline constexpr VehicleId kSecondary = 1;

/// Low space, so that searches are short.
inline GuideConfig quick_guide() {
  GuideConfig config;
  config.planner.primary.z_min_m = config.planner.secondary.z_min_m = 0.6;
  config.planner.primary.z_max_m = config.planner.secondary.z_max_m = 0.9;
  config.planner.primary.max_expansions = config.planner.secondary.max_expansions = 4000;
  config.planner.goal_search_m = 0.25;
  config.stage_timeout_s = 30.0;
  return config;
}

inline GuideConfig guides_uav2(std::vector<Eigen::Vector3d> goals_m) {
  GuideConfig config = quick_guide();
  config.secondary = "uav2";
  config.goals_m = std::move(goals_m);
  return config;
}

/// A vehicle that flies along the path that it received at 1 m/s, without inertia.
struct GuidedVehicle : RelativeEstimate {
  GuidedVehicle(VehicleId id, const Vector3& start_m) {
    other = id;
    position_m = start_m;
    covariance.setIdentity();
    covariance *= 1e-4;
  }
  /// Estimate at an instant; positions of the vehicle's own reports only while these are received.
  void observe(TimeNs now, bool is_heard = true) {
    t = seen = now;
    report_yaw_rad = yaw_rad;
    if (!is_heard) return;
    report_t = report_stamp = now;
    report_position_m = position_m;
  }
  void receive(const GuidingPath& path) {
    newest = path;
    path_local_m.clear();
    const Eigen::AngleAxisd turn(report_yaw_rad, Vector3::UnitZ());
    for (const GuidingWaypoint& waypoint : path.waypoints) {
      path_local_m.push_back(report_position_m + turn * waypoint.p_body_m.cast<double>());
    }
  }
  void fly(double tick_s) {
    velocity_mps.setZero();
    if (path_local_m.empty() || stuck) return;
    velocity_mps = velocity_toward(path_local_m.front(), position_m, tick_s);
    position_m += tick_s * velocity_mps;
    while (path_local_m.size() > 1 && (path_local_m.front() - position_m).norm() < 0.2) {
      path_local_m.erase(path_local_m.begin());
    }
  }

  bool localized = true, stuck = false;
  GuidingPath newest;
  std::vector<Vector3> path_local_m;
};

/// A guide and the vehicle that it guides.
struct GuideAndGuided : GuidanceDriver {
  explicit GuideAndGuided(const GuideConfig& config, CellListMap world = CellListMap(0.25),
                          const Vector3& primary_m = {-4, -3, 0.7}, const Vector3& secondary_m = {0, 0, 0.7})
      : GuidanceDriver("guide", config, primary_m), guided(kSecondary, secondary_m), world_(std::move(world)) {
    map = &world_;
    guided.yaw_rad = 2.0;
  }

  void tick() {
    observe_and_step();
    notes[out.note] = to_seconds(observation.t);
    std::vector<Message> sent;
    outbox.empty_into(sent);
    for (const Message& message : sent) take(message);
    approach();
    guided.fly(dt_s);
    flown_local_m.push_back(guided.position_m);
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / dt_s) && out.mission != MissionStatus::kDone &&
                    out.mission != MissionStatus::kFailed;
         ++i) {
      tick();
    }
  }
  void run_until(const std::string& note, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / dt_s) && out.note != note; ++i) tick();
  }
  /// One tick in which no vehicle moves, whatever the messages.
  void hold(double own_mps = 0.0, double guided_mps = 0.0) {
    guided.velocity_mps = {guided_mps, 0, 0};
    estimate.v_local_mps = {0, own_mps, 0};
    observe_and_step();
  }
  /// A scan reveals an obstacle.
  void discover(const Vector3& min_local_m, const Vector3& max_local_m) { world_.occupy_box(min_local_m, max_local_m); }
  /// A scan reveals a column of half a meter around a place.
  void discover_around(const Vector3& p_local_m) {
    discover(p_local_m - Vector3(0.25, 0.25, 0.75), p_local_m + Vector3(0.25, 0.25, 0.75));
  }
  bool noted(const std::string& note) const { return notes.count(note) > 0; }

  GuidedVehicle guided;
  bool hears = true;
  std::vector<Vector3> flown_local_m;
  std::vector<std::size_t> message_sizes;
  std::map<std::string, double> notes;  // time of the last report of each note

 private:
  void observe_and_step() {
    guided.observe(observation.t + from_seconds(dt_s), hears);
    relatives.clear();
    if (guided.localized) relatives.push_back(guided);
    step();
  }
  void take(const Message& message) {
    EXPECT_EQ(message.to, kSecondary);
    GuidingPath path;
    ASSERT_EQ(read_message(message, path), Reading::kDone);
    message_sizes.push_back(message.size_bytes());
    EXPECT_TRUE(path.waypoints.empty() || path.t == guided.report_stamp);
    guided.receive(path);
  }

  CellListMap world_;
};

inline void hold_for(GuideAndGuided& team, double seconds, double own_mps = 0.0, double guided_mps = 0.0) {
  for (int i = 0; i < static_cast<int>(std::lround(seconds / team.dt_s)); ++i) team.hold(own_mps, guided_mps);
}
/// Holds until the note is reported.
inline double hold_until(GuideAndGuided& team, const std::string& note, double longest_s) {
  const TimeNs from = team.observation.t;
  while (team.out.note != note && team.observation.t < from + from_seconds(longest_s)) team.hold();
  EXPECT_EQ(team.out.note, note);
  return to_seconds(team.observation.t - from);
}
/// Paths sent since the last call.
inline std::vector<GuidingPath> sent_paths(GuideAndGuided& team) {
  std::vector<Message> sent;
  team.outbox.empty_into(sent);
  std::vector<GuidingPath> paths(sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_EQ(read_message(sent[i], paths[i]), Reading::kDone);
  return paths;
}

inline GuidingPath newest(GuideAndGuided& team) {
  const std::vector<GuidingPath> paths = sent_paths(team);
  EXPECT_FALSE(paths.empty());
  return paths.empty() ? GuidingPath() : paths.back();
}

/// The guide hovers at its viewpoint and the guided vehicle may fly.
inline void place_at_viewpoint(GuideAndGuided& team) {
  hold_until(team, "primary moving", 5.0);
  for (int i = 0; i < 20 && team.out.note == std::string("primary moving"); ++i) {  // corner by corner
    team.hold();
    team.put(team.out.goal.position_m);
  }
  ASSERT_STREQ(team.out.note, "secondary moving");
  sent_paths(team);
}

/// The guided vehicle flies along x, a decimeter a tick.
inline void fly_to(GuideAndGuided& team, double x_m) {
  while (team.guided.position_m.x() < x_m - 0.1) {
    team.guided.position_m.x() += 0.1;
    team.hold(0.0, 1.0);
  }
  team.guided.position_m.x() = x_m;
}

}  // namespace swiftlet::testing
