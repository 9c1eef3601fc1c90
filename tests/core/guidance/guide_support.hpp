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

/// A guide and a guided vehicle that both fly to their goals at 1 m/s without inertia.
struct GuideAndGuided : GuidanceDriver {
  explicit GuideAndGuided(const GuideConfig& config, CellListMap world = CellListMap(0.25),
                          const Vector3& primary_m = {-4, -3, 0.7}, const Vector3& secondary_m = {0, 0, 0.7})
      : GuidanceDriver("guide", config, primary_m), world_(std::move(world)) {
    map = &world_;
    guided.other = kSecondary;
    guided.position_m = secondary_m;
    guided.yaw_rad = 2.0;
    guided.covariance.setIdentity();
    guided.covariance *= 1e-4;
  }

  void tick() {
    guided.t = guided.seen = observation.t + from_seconds(dt_s);
    if (hears) guided.heard = guided.heard_stamp = guided.t;
    if (hears) guided.heard_position_m = guided.position_m;
    guided.heard_yaw_rad = guided.yaw_rad;
    relatives.clear();
    if (localized) relatives.push_back(guided);
    step();
    notes[out.note] = to_seconds(observation.t);
    for (const Message& message : outbox.messages()) take(message);
    std::vector<Message> sent;
    outbox.empty_into(sent);
    estimate.v_local_mps = fly(out.goal.position_m, estimate.T_local_body.translation());
    put(p_m() + dt_s * estimate.v_local_mps);
    guided.velocity_mps =
        told_local_m.empty() || stuck ? Vector3(Vector3::Zero()) : fly(told_local_m.front(), guided.position_m);
    guided.position_m += dt_s * guided.velocity_mps;
    while (told_local_m.size() > 1 && (told_local_m.front() - guided.position_m).norm() < 0.2) {
      told_local_m.erase(told_local_m.begin());
    }
    flown_local_m.push_back(guided.position_m);
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / dt_s) && out.mission != MissionStatus::kDone &&
                    out.mission != MissionStatus::kFailed;
         ++i) {
      tick();
    }
  }
  /// A scan reveals an obstacle.
  void discover(const Vector3& min_local_m, const Vector3& max_local_m) { world_.occupy_box(min_local_m, max_local_m); }
  void run_until(const std::string& note, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / dt_s) && out.note != note; ++i) tick();
  }
  bool said(const std::string& note) const { return notes.count(note) > 0; }

  RelativeEstimate guided;
  bool hears = true, localized = true, stuck = false;
  std::vector<Vector3> told_local_m, flown_local_m;
  std::vector<std::size_t> told_sizes;
  GuidingPath::Word word = GuidingPath::Word::kGuide;  // the newest
  double radius_m = 0.0;
  std::map<std::string, double> notes;  // time of the last report of each note

 private:
  Vector3 fly(const Vector3& goal_m, const Vector3& from_m) const {
    const Vector3 way = goal_m - from_m;
    return way.norm() < 1.0 * dt_s ? Vector3(way / dt_s) : Vector3(way.normalized());
  }
  void take(const Message& message) {
    EXPECT_EQ(message.to, kSecondary);
    GuidingPath path;
    ASSERT_EQ(read_message(message, path), Reading::kDone);
    told_sizes.push_back(message.size_bytes());
    word = path.word;
    radius_m = path.radius_m;
    told_local_m.clear();
    EXPECT_TRUE(path.waypoints.empty() || path.t == guided.heard_stamp);
    const Eigen::AngleAxisd turn(guided.heard_yaw_rad, Vector3::UnitZ());
    for (const GuidingWaypoint& waypoint : path.waypoints) {
      told_local_m.push_back(guided.heard_position_m + turn * waypoint.p_body_m.cast<double>());
    }
  }

  CellListMap world_;
};

/// One tick in which no vehicle moves, whatever the messages.
inline void hold(GuideAndGuided& team, double own_mps = 0.0, double its_mps = 0.0) {
  team.guided.t = team.guided.seen = team.observation.t + from_seconds(team.dt_s);
  if (team.hears) team.guided.heard = team.guided.heard_stamp = team.guided.t;
  team.guided.heard_position_m = team.guided.position_m;
  team.guided.heard_yaw_rad = team.guided.yaw_rad;
  team.guided.velocity_mps = {its_mps, 0, 0};
  team.estimate.v_local_mps = {0, own_mps, 0};
  team.relatives.clear();
  if (team.localized) team.relatives.push_back(team.guided);
  team.step();
}
inline void hold_for(GuideAndGuided& team, double seconds, double own_mps = 0.0, double its_mps = 0.0) {
  for (int i = 0; i < static_cast<int>(std::lround(seconds / team.dt_s)); ++i) hold(team, own_mps, its_mps);
}
/// Holds until the note is reported.
inline double hold_until(GuideAndGuided& team, const std::string& note, double longest_s) {
  const TimeNs from = team.observation.t;
  while (team.out.note != note && team.observation.t < from + from_seconds(longest_s)) hold(team);
  EXPECT_EQ(team.out.note, note);
  return to_seconds(team.observation.t - from);
}
/// Paths sent since the last call.
inline std::vector<GuidingPath> heard(GuideAndGuided& team) {
  std::vector<Message> sent;
  team.outbox.empty_into(sent);
  std::vector<GuidingPath> paths(sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_EQ(read_message(sent[i], paths[i]), Reading::kDone);
  return paths;
}

inline GuidingPath newest(GuideAndGuided& team) {
  const std::vector<GuidingPath> paths = heard(team);
  EXPECT_FALSE(paths.empty());
  return paths.empty() ? GuidingPath() : paths.back();
}

/// The guide stands at its viewpoint, and the other one may go.
inline void place_at_viewpoint(GuideAndGuided& team) {
  hold_until(team, "primary moving", 5.0);
  for (int i = 0; i < 20 && team.out.note == std::string("primary moving"); ++i) {  // corner by corner
    hold(team);
    team.put(team.out.goal.position_m);
  }
  ASSERT_STREQ(team.out.note, "secondary moving");
  heard(team);
}

/// The guided one flies along x, a decimeter a tick.
inline void fly_to(GuideAndGuided& team, double x_m) {
  while (team.guided.position_m.x() < x_m - 0.1) {
    team.guided.position_m.x() += 0.1;
    hold(team, 0.0, 1.0);
  }
  team.guided.position_m.x() = x_m;
}

}  // namespace swiftlet::testing
