// SPDX-License-Identifier: BSD-3-Clause
// Several vehicles with markers: unknown positions, and sightings without identity.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "core/localization/motion_match.hpp"
#include "swiftlet/core/stage_tables/relative_localizers.hpp"
#include "tests/core/localization/relative_support.hpp"

namespace swiftlet {
namespace {

constexpr double kObserved_s = 0.05;

Path shifted(const Path& path, const Vector3& by_m) {
  return [=](double t) { return Vector3(path(t) + by_m); };
}

struct Known {
  double first_s = 1e9, worst_m = 0.0, sum_m = 0.0;
  int count = 0;
  bool known_at_end = false;
  double mean_m() const { return sum_m / std::max(count, 1); }
};

/// An observer at rest, with uav2, uav3 and so on around it.
struct Several {
  std::vector<Path> paths;
  std::vector<bool> silent = std::vector<bool>(8, false);

  std::vector<Known> fly(double duration_s, std::uint64_t seed) const {
    AgentSetup setup;
    setup.vehicle_names = {"uav1"};
    Module module(relative_localizer_module_types(), "sliding_window");
    auto& config = module.as<SlidingWindowConfig>();
    config.source = SlidingWindowConfig::Source::kDetections;
    std::vector<OtherFlight> flights;
    for (std::size_t i = 0; i < paths.size(); ++i) {
      setup.vehicle_names.push_back("uav" + std::to_string(i + 2));
      config.others.push_back(setup.vehicle_names.back());
      flights.emplace_back(paths[i], duration_s + 1.0, OdometryDriftConfig{}, 100 * seed + i);
    }
    setup.num_vehicles = static_cast<int>(setup.vehicle_names.size());
    const auto localizer = make_relative_localizer(module, setup);

    std::vector<Known> results(paths.size());
    StateEstimate estimate;
    estimate.valid = true;
    LocalPoses poses;
    Outbox outbox(0);
    for (int k = 20; k < static_cast<int>(duration_s / kObserved_s); ++k) {
      Observation observation;
      observation.t = estimate.t = from_seconds(k * kObserved_s);
      poses.push(estimate);
      std::vector<Detection> detections;
      for (std::size_t i = 0; i < paths.size(); ++i) {
        if (k % 10 == static_cast<int>(i) && !silent[i]) observation.messages.push_back(report(flights[i], i, k));
        if (k % 2 == 0) detections.push_back(detection(flights[i], Random(seed, "test.team", std::to_string(i)), k));
      }
      std::vector<RelativeEstimate> found;
      localizer->step({.observation = observation, .estimate = estimate, .poses = poses, .detections = detections},
                      found, outbox);
      for (Known& result : results) result.known_at_end = false;
      for (const RelativeEstimate& relative : found) {
        const std::size_t i = static_cast<std::size_t>(relative.other) - 1;
        const double error_m = (relative.position_m - flights[i].at(k * kObserved_s).p_local_m).norm();
        Known& result = results[i];
        result.first_s = std::min(result.first_s, k * kObserved_s);
        result.worst_m = std::max(result.worst_m, error_m);
        result.sum_m += error_m;
        ++result.count;
        result.known_at_end = true;
      }
    }
    return results;
  }

 private:
  static Message report(const OtherFlight& flight, std::size_t i, int k) {
    const OtherMotion& motion = flight.at(k * kObserved_s - 0.1).motion;
    return odometry_message(motion, static_cast<VehicleId>(i + 1), from_seconds(k * kObserved_s - 0.1),
                            from_seconds(k * kObserved_s));
  }
  static Detection detection(const OtherFlight& flight, const Random& random, int k) {
    Detection d;
    d.t = from_seconds((k - 3) * kObserved_s);
    d.covariance = sighting_covariance();
    d.position_m = sighting_of(flight, (k - 3) * kObserved_s, d.covariance, random);
    d.reflectivity = 18.0;
    return d;
  }
};

Several three_different_paths() {
  return {{eight(1.0, 0.5), shifted(eight(0.8, 0.7), {2.0, -3.0, 0.0}), shifted(eight(1.2, 0.35), {-1.0, 4.0, 0.0})}};
}

TEST(SeveralTeammates, AreDistinguishedByTheirMotion) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    for (const Known& result : three_different_paths().fly(40.0, seed)) {
      EXPECT_LT(result.first_s, 20.0) << seed;
      EXPECT_LT(result.mean_m(), 0.1) << seed;
      EXPECT_LT(result.worst_m, 0.6) << seed << ": a confusion is off by meters";
      EXPECT_TRUE(result.known_at_end) << seed;
    }
  }
}

TEST(SeveralTeammates, StayUnknownWhileMovingAlike) {
  const Path alike = eight();
  EXPECT_EQ((Several{{alike, shifted(alike, {1.0, -4.0, 0.0})}}.fly(30.0, 1)[0].count), 0);
  const Path turns_away = [alike](double t) { return Vector3(alike(std::min(t, 15.0)) + Vector3(1.0, -4.0, 0.0)); };
  const auto results = Several{{alike, turns_away}}.fly(40.0, 1);
  for (const Known& result : results) {
    EXPECT_GT(result.first_s, 15.0);
    EXPECT_TRUE(result.known_at_end);
    EXPECT_LT(result.worst_m, 0.6);
  }
}

TEST(SeveralTeammates, OnlySilentTeammateStaysUnknown) {
  Several team = three_different_paths();
  team.silent[2] = true;
  const auto results = team.fly(40.0, 3);
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(results[i].known_at_end);
    EXPECT_LT(results[i].worst_m, 0.6);
  }
  EXPECT_EQ(results[2].count, 0);
}

TEST(SeveralTeammates, AreNotConfusedDuringClosePassage) {
  // The first one rests from 20 s on; the second one then passes a meter beside it.
  const Path first = [](double t) { return eight()(std::min(t, 20.0)); };
  const Vector3 rest_m = first(20.0);
  const Path figure = shifted(eight(0.8, 0.7), {2.0, -5.0, 0.0});
  const Vector3 from_m = figure(25.0);
  const Path second = [=](double t) {
    if (t < 25.0) return figure(t);
    const Vector3 to_m = rest_m + (rest_m - from_m) + Vector3(1.0, 0.0, 0.0);
    return Vector3(from_m + std::min((t - 25.0) / 12.0, 1.0) * (to_m - from_m));
  };
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    for (const Known& result : Several{{first, second}}.fly(45.0, seed)) {
      EXPECT_TRUE(result.known_at_end) << seed;
      EXPECT_LT(result.mean_m(), 0.12) << seed;
      EXPECT_LT(result.worst_m, 0.9) << seed << ": they pass at a meter";
    }
  }
}

TEST(SeveralTeammates, RefuseDuplicateNames) {
  AgentSetup setup;
  setup.vehicle_names = {"uav1", "uav2"};
  setup.num_vehicles = 2;
  Module module(relative_localizer_module_types(), "sliding_window");
  module.as<SlidingWindowConfig>().others = {"uav2", "uav2"};
  try {
    make_relative_localizer(module, setup);
    FAIL();
  } catch (const std::invalid_argument& problem) {
    EXPECT_STREQ(problem.what(), "relative_localization.others: expected each name once, found \"uav2\" twice");
  }
}

}  // namespace
}  // namespace swiftlet
