// SPDX-License-Identifier: BSD-3-Clause
// Targets of every motion beside their formulas; lost ones beside what may have become of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "swiftlet/core/control/reference_governor.hpp"
#include "swiftlet/core/guidance/agile.hpp"
#include "swiftlet/core/guidance/trajectory.hpp"
#include "swiftlet/core/interception/target.hpp"
#include "swiftlet/core/interception/target_prediction.hpp"
#include "swiftlet/core/interception/target_search.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/overlay.hpp"
#include "swiftlet/core/tracking/motion_filter.hpp"
#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

using Motion = TargetConfig::Motion;

constexpr MotionLimits kMotion{8.0, 4.0, 60.0, 4.0, 2.0, 60.0, 2.0, 2.0};

/// A target whose local frame may lie anywhere in the world; it is where its goal is.
class Quarry {
 public:
  Quarry(const TargetConfig& config, const Vector3& start_m, double yaw_rad, const Pose& T_world_local) {
    setup_.T_local_body_start = make_pose(start_m, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ())));
    Module module(guidance_module_types(), "target");
    module.as<TargetConfig>() = config;
    guidance_ = make_guidance(module, {setup_, kMotion});
    estimate.valid = true;
    estimate.T_local_body = setup_.T_local_body_start;
    estimate.correct(T_world_local);
  }
  const Reference& step(double dt_s) {
    observation.t += from_seconds(dt_s);
    guidance_->step({.dt_s = dt_s, .estimate = estimate, .observation = observation, .poses = poses_, .tracks = tracks},
                    out, outbox_);
    estimate.T_local_body.translation() = out.goal.position_m;
    return out.goal;
  }
  StateEstimate estimate;
  Observation observation;
  std::vector<Track> tracks;
  GuidanceOutput out;

 private:
  AgentSetup setup_;
  std::unique_ptr<Guidance> guidance_;
  LocalPoses poses_;
  Outbox outbox_;
};

TargetConfig drawn_target(std::uint64_t seed, Motion motion) {
  const Random random(seed, "test.target");
  TargetConfig config;
  config.motion = motion;
  config.seed = seed;
  config.speed_mps = random.uniform(1.5, 6.0, 0, 0);
  config.acceleration_mps2 = random.uniform(1.0, 4.0, 0, 1);
  config.radius_m = random.uniform(2.0, 12.0, 0, 2);
  config.leg_min_m = random.uniform(5.0, 25.0, 0, 3);
  config.alarm_m = random.uniform(6.0, 14.0, 0, 4);
  config.cruise = random.uniform(0.3, 1.0, 0, 5);
  for (Vector3* corner_m : {&config.area_min_m, &config.area_max_m}) *corner_m += Vector3(11.0, -7.0, 0.0);
  return config;
}

const Pose kShifted = level_alignment(0.8, {4.0, -3.0, 1.0}, Vector3::Zero());

/// Where its goal and velocity are in the world, and where it looks.
void compare(const Quarry& quarry, const Vector3& p_world_m, const Vector3& v_world_mps, double& yaw_rad) {
  const Reference& r = quarry.out.goal;
  ASSERT_LT((quarry.estimate.T_world_local * r.position_m - p_world_m).norm(), 1e-8);
  ASSERT_LT((quarry.estimate.T_world_local.linear() * r.velocity_mps - v_world_mps).norm(), 1e-8);
  if (r.velocity_mps.head<2>().norm() > 0.5) yaw_rad = std::atan2(r.velocity_mps.y(), r.velocity_mps.x());
  ASSERT_NEAR(r.yaw_rad, yaw_rad, 1e-9);
  ASSERT_EQ(r.yaw_rate_radps, 0.0);
  ASSERT_EQ(quarry.out.mission, MissionStatus::kEndless);
}

TEST(TargetReference, CirclesAndEightsAreThoseOfTheDraw) {
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const bool eight = seed % 2 == 0;
    TargetConfig config = drawn_target(seed, eight ? Motion::kFigureEight : Motion::kCircle);
    const Vector3 middle_m = 0.5 * (config.area_min_m + config.area_max_m);
    // Off the middle of its box, or so near to it that the direction is drawn, too.
    const double off_m = std::array{7.0, 1.01, 0.99, 0.0}[(seed / 2) % 4];
    const Vector3 start_world_m = middle_m + off_m * Vector3(0.6, -0.8, 0.0) + Vector3(0, 0, 2.0);
    Quarry quarry(config, kShifted.inverse() * start_world_m, 0.3, kShifted);

    const Random random(seed, "guidance.target");
    const double sense = random.uniform(0, 1) < 0.5 ? -1.0 : 1.0, heading = 2.0 * M_PI * random.uniform(1, 1);
    const double radius_m = std::max(config.radius_m, 1.3 * std::pow(config.speed_mps, 2) / config.acceleration_mps2);
    const Vector3 drawn(std::cos(heading), std::sin(heading), 0.0);
    const Vector3 inward = off_m < 1.0 ? drawn : Vector3(-0.6, 0.8, 0.0);
    // An eight is as fast as told where it crosses itself, at most: the square root of 2 and a little.
    const double rate = config.speed_mps / radius_m / (eight ? 1.42 : 1.0);
    const RampedTravel travel(std::numeric_limits<double>::infinity(), rate,
                              2.0 * 1.875 * config.speed_mps / config.acceleration_mps2);
    double yaw_rad = 0.3;
    for (int i = 1; i < 1500; ++i) {
      quarry.step(0.02);
      const auto [s, ds, dds] = travel.at(0.02 * i);
      Vector3 p_m, v_mps;
      const auto turned_left = [&](const Vector3& v) { return Vector3(-v.y(), v.x(), 0.0); };
      if (eight) {
        p_m = start_world_m + radius_m * (std::sin(s) * drawn + 0.5 * std::sin(2.0 * s) * sense * turned_left(drawn));
        v_mps = ds * radius_m * (std::cos(s) * drawn + std::cos(2.0 * s) * sense * turned_left(drawn));
      } else {
        const Vector3 across = sense * turned_left(inward);
        p_m = start_world_m + radius_m * (inward - std::cos(s) * inward + std::sin(s) * across);
        v_mps = ds * radius_m * (std::sin(s) * inward + std::cos(s) * across);
      }
      ASSERT_NO_FATAL_FAILURE(compare(quarry, p_m, v_mps, yaw_rad)) << seed << ", " << i;
      ASSERT_LE(quarry.out.goal.acceleration_mps2.norm(), config.acceleration_mps2 * (1 + 1e-9));
    }
  }
}

/// The places that a seed leads to, one after the other: each a leg away from the last, unless 32 draws find none.
class Places {
 public:
  Places(const TargetConfig& config) : config_(config), random_(config.seed, "guidance.target") {}
  Vector3 after(const Vector3& last_m) {
    Vector3 place_m;
    int tries = 0;
    do {
      ++num_drawn_;
      for (int i = 0; i < 3; ++i)
        place_m[i] = random_.uniform(config_.area_min_m[i], config_.area_max_m[i], num_drawn_,
                                     16 + static_cast<std::uint32_t>(i));
    } while (++tries < 32 && (place_m - last_m).norm() < config_.leg_min_m);
    return place_m;
  }

 private:
  TargetConfig config_;
  Random random_;
  std::uint32_t num_drawn_ = 0;
};

TEST(TargetReference, LinesLeadFromPlaceToPlace) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    TargetConfig config = drawn_target(seed, Motion::kLine);
    if (seed == 6) config.leg_min_m = 90.0;  // no place is that far away
    const Vector3 start_world_m(5, -3, 10);
    Quarry quarry(config, kShifted.inverse() * start_world_m, 0.3, kShifted);
    Places places(config);
    Vector3 at_m = start_world_m, next_m = places.after(at_m);
    double yaw_rad = 0.3;
    for (int i = 1; i < 3000; ++i) {
      const double dt_s = i % 500 == 0 ? 15.0 : 0.05;  // a step may take it past several places
      quarry.step(dt_s);
      double left_m = config.speed_mps * dt_s;
      while ((next_m - at_m).norm() <= left_m) {
        left_m -= (next_m - at_m).norm();
        at_m = next_m;
        next_m = places.after(at_m);
      }
      at_m += left_m * (next_m - at_m).normalized();
      ASSERT_NO_FATAL_FAILURE(compare(quarry, at_m, config.speed_mps * (next_m - at_m).normalized(), yaw_rad)) << i;
    }
  }
}

TEST(TargetReference, AtRandomItFliesAsTheAgileOnesDo) {
  const TargetConfig config = drawn_target(3, Motion::kRandom);
  const Vector3 start_world_m(5, -3, 10);
  Quarry quarry(config, kShifted.inverse() * start_world_m, 0.3, kShifted);
  AgileConfig agile;
  agile.seed = 3;
  agile.speed_max_mps = config.speed_mps;
  agile.acceleration_max_mps2 = config.acceleration_mps2;
  agile.area_min_m = config.area_min_m;
  agile.area_max_m = config.area_max_m;
  agile.leg_min_m = config.leg_min_m;
  AgileSpline spline(agile, start_world_m, kMotion.vertical_speed_mps, kMotion.vertical_acceleration_mps2);
  double yaw_rad = 0.3;
  for (int i = 1; i < 2000; ++i) {
    quarry.step(0.05);
    spline.advance(0.05);
    ASSERT_NO_FATAL_FAILURE(compare(quarry, spline.reference().position_m, spline.reference().velocity_mps, yaw_rad));
  }
}

TEST(TargetReference, WhoHoversStaysInItsOwnFrame) {
  Quarry quarry(drawn_target(1, Motion::kHover), {1, 2, 3}, 0.3, kShifted);
  EXPECT_EQ(quarry.step(0.1).position_m, Vector3(1, 2, 3));
  EXPECT_NEAR(quarry.out.goal.yaw_rad, 0.3, 1e-12);
  EXPECT_FALSE(quarry.out.goal_is_feasible);
}

TEST(TargetReference, EvadersFleeFromTheNearestYoungTrackAndShyAwayFromTheirBox) {
  int flees = 0, cruises = 0, shy = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const TargetConfig config = drawn_target(seed, Motion::kEvasive);
    const Vector3 start_world_m(5, -3, 10);
    Quarry quarry(config, kShifted.inverse() * start_world_m, 0.3, kShifted);
    Places places(config);
    const Random random(seed, "guidance.target"), around(seed, "test.pursuers");
    ReferenceGovernor governor(kMotion);
    Reference at_rest;
    at_rest.position_m = start_world_m;
    at_rest.yaw_rad = 0.3 + 0.8;
    governor.reset(at_rest);
    Vector3 next_m = start_world_m;
    double flown_s = 0.0;
    double yaw_rad = 0.3;
    for (std::uint32_t i = 1; i < 2500; ++i) {
      const double t_s = 0.02 * i;
      flown_s += 0.02;
      quarry.tracks.resize(3);
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t leg = i / 150;
        Track& track = quarry.tracks[k];
        track.position_m = quarry.estimate.T_local_body.translation() +
                           Vector3(around.uniform(-14, 14, leg, 10 * k), around.uniform(-14, 14, leg, 10 * k + 1),
                                   around.uniform(-4, 4, leg, 10 * k + 2));
        const double age_s = around.uniform(leg, 10 * k + 3) < 0.5 ? 0.69 : 0.71;
        track.t = from_seconds(t_s) - from_seconds(age_s);
      }
      const Vector3 p_m = governor.state().position_m;
      if ((next_m - p_m).norm() < 3.0) next_m = places.after(next_m);
      const Track* nearest = nullptr;
      for (const Track& track : quarry.tracks) {
        const auto off_m = [&](const Track& one) {
          return (one.position_m - quarry.estimate.T_local_body.translation()).norm();
        };
        const bool counts = to_seconds(from_seconds(t_s) - track.t) <= 0.7 && off_m(track) < config.alarm_m;
        if (counts && (nearest == nullptr || off_m(track) < off_m(*nearest))) nearest = &track;
      }
      Vector3 v_mps = config.cruise * config.speed_mps * (next_m - p_m).normalized();
      if (nearest != nullptr) {
        const Vector3 away = (p_m - kShifted * nearest->position_m).normalized();
        const auto jink = static_cast<std::uint32_t>(flown_s / 1.2);
        const double side = random.uniform(jink, 66) < 0.5 ? -1.0 : 1.0;
        const Vector3 across(-side * away.y(), side * away.x(), random.uniform(jink, 67) - 0.5);
        v_mps = config.speed_mps * (away + 0.7 * across).normalized();
      }
      (nearest != nullptr ? flees : cruises) += 1;
      for (int axis = 0; axis < 3; ++axis) {
        const double low_m = config.area_min_m[axis], high_m = config.area_max_m[axis];
        const double from_m = std::min(5.0, 0.3 * (high_m - low_m));
        // As fast inward at a side as it may be, not at all halfway, and outward at most as fast as it may beyond.
        const double inward = config.speed_mps * (1.0 - 2.0 * (p_m[axis] - low_m) / from_m);
        const double outward = -config.speed_mps * (1.0 - 2.0 * (high_m - p_m[axis]) / from_m);
        const double wanted = v_mps[axis];
        if (p_m[axis] - low_m < from_m) v_mps[axis] = std::max(v_mps[axis], inward);
        if (high_m - p_m[axis] < from_m) v_mps[axis] = std::min(v_mps[axis], outward);
        shy += v_mps[axis] != wanted;
      }
      if (v_mps.norm() > config.speed_mps) v_mps = config.speed_mps * v_mps.normalized();
      Vector3 a_mps2 = 2.5 * (v_mps - governor.state().velocity_mps);
      if (a_mps2.norm() > config.acceleration_mps2) a_mps2 = config.acceleration_mps2 * a_mps2.normalized();
      governor.accelerate(a_mps2, governor.state().yaw_rad, 0.02);
      quarry.step(0.02);
      ASSERT_NO_FATAL_FAILURE(compare(quarry, governor.state().position_m, governor.state().velocity_mps, yaw_rad))
          << seed << ", " << i;
      ASSERT_TRUE(quarry.out.goal_is_feasible);
    }
  }
  for (const int seen : {flees, cruises, shy}) EXPECT_GT(seen, 500);
}

TEST(TargetReference, MayAskForAllThatItsLimitsAllowAndForNoMore) {
  const auto is_refused = [](double speed_mps, double acceleration_mps2) {
    TargetConfig config;
    config.speed_mps = speed_mps;
    config.acceleration_mps2 = acceleration_mps2;
    try {
      const Quarry quarry(config, {0, 0, 10}, 0.0, Pose::Identity());
      return false;
    } catch (const std::invalid_argument&) {
      return true;
    }
  };
  EXPECT_FALSE(is_refused(8.0, 4.0));
  EXPECT_TRUE(is_refused(8.01, 4.0));
  EXPECT_TRUE(is_refused(8.0, 4.01));
}

// ---- where it will be

TEST(TargetPredictionReference, EveryMixtureIsThatOfItsModels) {
  for (std::uint32_t round = 0; round < 300; ++round) {
    const Random random(round, "test.prediction");
    std::uint32_t index = 0;
    const auto draw = [&](double min, double max) { return random.uniform(min, max, 0, index++); };
    const auto vector = [&](double half) {
      const double x = draw(-half, half), y = draw(-half, half);
      return Vector3(x, y, draw(-half, half));
    };
    TargetPredictionConfig config;
    config.acceleration_time_s = draw(0.2, 2.0);
    config.speed_max_mps = draw(3.0, 12.0);
    TrackModes modes;
    double sum = 0.0;
    for (double& p : modes.probability) sum += p = random.uniform(1, index++) < 0.3 ? 0.0 : draw(0.1, 1.0);
    if (sum == 0.0) continue;
    for (double& p : modes.probability) p /= sum;
    for (auto& mean : modes.mean_local_m) mean << vector(20.0), vector(5.0), vector(3.0);
    Track track;
    track.t = from_seconds(3.0);
    track.position_m = vector(20.0);
    track.velocity_mps = vector(5.0);
    track.acceleration_mps2 = vector(3.0);
    const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(9, 9, [&] { return draw(-0.5, 0.5); });
    track.covariance = root * root.transpose();
    const double age_s = draw(0.0, 0.8), ahead_s = draw(0.0, 2.5), t_s = age_s + ahead_s;
    const bool alone = round % 3 == 0;
    const TargetPrediction prediction(config, track, alone ? nullptr : &modes, track.t + from_seconds(age_s));

    const auto fading = [&](const Vector3& p, const Vector3& v, const Vector3& a) {
      // a exp(-t / T), integrated once and twice.
      const double T = config.acceleration_time_s, gone = 1.0 - std::exp(-t_s / T);
      return PointState{p + t_s * v + a * (T * t_s - T * T * gone), v + a * T * gone, {}};
    };
    PointState expected;
    if (alone) {
      expected = fading(track.position_m, track.velocity_mps, track.acceleration_mps2);
    } else {
      for (std::size_t m = 0; m < 3; ++m) {
        const Vector9& mean = modes.mean_local_m[m];
        const Vector3 p = mean.head<3>(), v = mean.segment<3>(3), a = mean.tail<3>();
        PointState part = fading(p, v, a);
        if (m == TrackModes::kConstantVelocity) part = {p + t_s * v, v, {}};
        if (m == TrackModes::kCoordinatedTurn) {
          const Vector9 then = coordinated_turn_transition(t_s, turn_rate_radps(mean)) * mean;
          part = {then.head<3>(), then.segment<3>(3), {}};
        }
        expected.p_m += modes.probability[m] * part.p_m;
        expected.v_mps += modes.probability[m] * part.v_mps;
      }
    }
    if (expected.v_mps.norm() > config.speed_max_mps)
      expected.v_mps = config.speed_max_mps * expected.v_mps.normalized();
    EXPECT_LT((prediction.at(ahead_s).p_m - expected.p_m).norm(), 1e-8) << round;
    EXPECT_LT((prediction.at(ahead_s).v_mps - expected.v_mps).norm(), 1e-8) << round;
    EXPECT_EQ(prediction.at(ahead_s).a_mps2, Vector3(0, 0, 0));
    // p + t v has the covariance (I, t I) P (I, t I)^T.
    Eigen::MatrixXd F = Eigen::MatrixXd::Zero(3, 9);
    F.leftCols(3).setIdentity();
    F.middleCols(3, 3) = t_s * Eigen::MatrixXd::Identity(3, 3);
    const Eigen::MatrixXd C = F * track.covariance * F.transpose();
    EXPECT_NEAR(prediction.sigma_m(ahead_s), std::sqrt(C.diagonal().maxCoeff()), 1e-9) << round;
  }
}

// ---- where a lost one may be

struct Maybe {
  Vector3 p_m, v_mps;
  double weight = 1.0;
};

/// All of them, as the picture shows them.
void compare(const TargetSearch& search, const std::vector<Maybe>& all) {
  std::vector<Overlay> overlays;
  search.append_overlay(overlays);
  ASSERT_EQ(overlays[0].positions.size(), all.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_LT((overlays[0].positions[i].cast<double>() - all[i].p_m).norm(), 2e-5) << i;
    ASSERT_NEAR(overlays[0].colors[i].w(), std::clamp(all[i].weight, 0.15, 1.0), 1e-6);
    sum += all[i].weight;
  }
  ASSERT_NEAR(search.remaining(), sum / 200.0, 1e-9);
  // The middle of the heaviest crowd within 4 m of one of them.
  double most = -1.0;
  Vector3 best_m;
  for (const Maybe& center : all) {
    double crowd = 0.0;
    Vector3 middle_m = Vector3::Zero();
    for (const Maybe& one : all) {
      if ((one.p_m - center.p_m).norm() > 4.0) continue;
      crowd += one.weight;
      middle_m += one.weight * one.p_m;
    }
    if (crowd <= most + 1e-9) continue;
    most = crowd;
    best_m = middle_m / crowd;
  }
  ASSERT_LT((search.most_probable() - best_m).norm(), 1e-6);
  for (const Vector3& here_m : {best_m, Vector3(best_m + Vector3(3.0, 0.0, 7.0)), all[0].p_m}) {
    double highest_m = -1e300;
    for (const Maybe& one : all) {
      const bool near = std::hypot(one.p_m.x() - here_m.x(), one.p_m.y() - here_m.y()) <= 4.0;
      if (near && one.weight >= 0.1) highest_m = std::max(highest_m, one.p_m.z());
    }
    ASSERT_NEAR(std::max(search.highest_near_m(here_m), -1e300), highest_m, 1e-6);
  }
}

/// A wall of x = 6 m, up to 14 m high.
struct HighWall : testing::ToldMap {
  HighWall() : testing::ToldMap({}) {}
  std::optional<SegmentHit> first_hit(const Vector3& from, const Vector3& to) const override {
    if ((from.x() - 6.0) * (to.x() - 6.0) >= 0.0) return std::nullopt;
    const Vector3 at = from + (6.0 - from.x()) / (to.x() - from.x()) * (to - from);
    return at.z() < 14.0 ? std::optional<SegmentHit>(SegmentHit{}) : std::nullopt;
  }
};

TEST(TargetSearchReference, EveryParticleFliesOnAndIsSeenByTheRules) {
  const HighWall wall;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    TargetSearchConfig config;
    config.seed = seed;
    config.speed_max_mps = 5.0;
    config.acceleration_mps2 = 0.5 + 0.5 * static_cast<double>(seed);
    config.range_m = 15.0;
    config.fov_bottom_deg = -15.0;
    config.fov_top_deg = 25.0;
    config.detection_rate_per_s = 1.5;
    GeofenceConfig fence_config;
    fence_config.min_m = {-10, -8, 2};
    fence_config.max_m = {12, 14, 18};
    const Geofence fence(fence_config, FrameChange());
    TargetSearch search(config);
    const Random random(seed, "guidance.search");
    std::vector<Maybe> all(200);
    std::uint32_t draws = 0;
    for (int lost = 0; lost < 2; ++lost) {  // once and again
      const PointState target{{4.0, 1.0, 9.0 + lost}, {2.0, -1.0, 0.5}, {}};
      search.begin(target, 1.5, 0.8);
      ++draws;
      for (std::uint32_t i = 0; i < 200; ++i) {
        const auto p = random.normal3(draws, 2 * i), v = random.normal3(draws, 2 * i + 1);
        all[i] = {target.p_m + 1.5 * Vector3(p[0], p[1], p[2]), target.v_mps + 0.8 * Vector3(v[0], v[1], v[2]), 1.0};
      }
      ASSERT_NO_FATAL_FAILURE(compare(search, all));
      for (int step = 0; step < 12; ++step) {
        const double asked_s = step == 5 ? 1.7 : 0.2, h = std::min(asked_s, 1.0);
        search.advance(asked_s, fence);
        ++draws;
        for (std::uint32_t i = 0; i < 200; ++i) {
          Maybe& one = all[i];
          const auto n = random.normal3(draws, i);
          // White noise of the acceleration that a particle keeps for 0.7 s; less of it up and down.
          one.v_mps += config.acceleration_mps2 * std::sqrt(h / 0.7) * Vector3(n[0], n[1], 0.4 * n[2]);
          if (one.v_mps.norm() > 5.0) one.v_mps = 5.0 * one.v_mps.normalized();
          one.p_m += h * one.v_mps;
          for (int axis = 0; axis < 3; ++axis) {
            const double low = fence_config.min_m[axis], high = fence_config.max_m[axis];
            if (one.p_m[axis] > low && one.p_m[axis] < high) continue;
            const bool leaves = one.p_m[axis] <= low ? one.v_mps[axis] < 0.0 : one.v_mps[axis] > 0.0;
            one.p_m[axis] = std::clamp(one.p_m[axis], low, high);
            if (leaves) one.v_mps[axis] *= -1.0;
          }
        }
        const Vector3 eye_m(-3.0 + step, 0.5 * step, 8.0);
        const OccupancyView* map = step % 2 == 0 ? &wall : nullptr;
        const double look_s = step == 7 ? 30.0 : 0.2;
        search.look(eye_m, look_s, map);
        for (Maybe& one : all) {
          const Vector3 to_m = one.p_m - eye_m;
          const double elevation_deg = std::atan2(to_m.z(), to_m.head<2>().norm()) * 180.0 / M_PI;
          const bool seen = to_m.norm() <= 15.0 && elevation_deg >= -15.0 && elevation_deg <= 25.0 &&
                            (map == nullptr || !map->first_hit(eye_m, one.p_m));
          if (seen) one.weight = std::max(1e-6, one.weight * std::exp(-1.5 * look_s));
        }
        ASSERT_NO_FATAL_FAILURE(compare(search, all)) << seed << ", step " << step;
      }
    }
  }
}

}  // namespace
}  // namespace swiftlet
