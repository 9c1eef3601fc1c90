// SPDX-License-Identifier: BSD-3-Clause
// Parts of relative localization: clocks, chains of sightings, assignment by motion, and the stage.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "core/localization/teammate.hpp"
#include "swiftlet/core/stage_tables/relative_localizers.hpp"
#include "tests/core/localization/relative_support.hpp"

namespace swiftlet {
namespace {

using ClockMode = SlidingWindowConfig::Clock;

TEST(OtherClock, IsTakenAsIsWhenSynchronized) {
  OtherClock clock(ClockMode::kSynchronized, 0.02, 0.01);
  TimeNs stamp = 5 * kNsPerSecond;
  EXPECT_TRUE(clock.take(stamp, 6 * kNsPerSecond));
  EXPECT_EQ(stamp, 5 * kNsPerSecond);
  EXPECT_EQ(clock.prior().clock_s, 0.0);
  EXPECT_EQ(clock.prior().sigma_s, 0.02);
}

TEST(OtherClock, UsesTheQuickestRecentMessage) {
  OtherClock clock(ClockMode::kOneWay, 0.1, 0.01);
  EXPECT_EQ(clock.prior().clock_s, 0.0) << "no message yet";
  const TimeNs behind = 1000 * kNsPerSecond;
  const auto hear = [&](int i, double took_s) {
    const TimeNs sent = i * kNsPerSecond;
    TimeNs stamp = sent - behind;
    EXPECT_TRUE(clock.take(stamp, sent + from_seconds(took_s)));
    return to_seconds(stamp - sent);
  };
  EXPECT_NEAR(hear(0, 0.5), 0.5, 1e-9) << "the first message has no assumed delay";
  EXPECT_NEAR(hear(1, 0.2), 0.5, 1e-9) << "constant offset";
  EXPECT_NEAR(clock.prior().clock_s, -0.3 - 0.01, 1e-9);
  for (int i = 2; i < 65; ++i) hear(i, 0.4);
  EXPECT_NEAR(clock.prior().clock_s, -0.31, 1e-9);
  hear(65, 0.4);
  EXPECT_NEAR(clock.prior().clock_s, -0.11, 1e-9) << "the quickest one is too old";
  EXPECT_EQ(clock.prior().sigma_s, 0.1);
}

TEST(OtherClock, RestartsAfterALargeJump) {
  for (const double jump_s : {1.0, -1.0, 100.0, -100.0}) {
    OtherClock clock(ClockMode::kOneWay, 0.1, 0.0);
    TimeNs stamp = 0;
    EXPECT_TRUE(clock.take(stamp, kNsPerSecond));
    stamp = kNsPerSecond;
    const bool small = std::abs(jump_s) < 10.0;
    const TimeNs received = 2 * kNsPerSecond + from_seconds(jump_s);
    EXPECT_EQ(clock.take(stamp, received), small) << jump_s;
    TimeNs next = 2 * kNsPerSecond;
    EXPECT_TRUE(clock.take(next, received + kNsPerSecond));
    EXPECT_EQ(next, small ? 3 * kNsPerSecond : received + kNsPerSecond);
  }
}

// ---- chains

Sighting seen_at(double t_s, const Vector3& p_m) { return {from_seconds(t_s), p_m, 0.01 * Matrix3::Identity()}; }

TEST(SightingChain, ExtendsTheNearestChain) {
  SightingChains chains;
  chains.push(seen_at(1.0, {0, 0, 0}));
  chains.push(seen_at(1.0, {1, 0, 0}));
  chains.push(seen_at(1.1, {0.55, 0, 0}));
  chains.push(seen_at(1.1, {0.2, 0, 0}));
  ASSERT_EQ(chains.chains().size(), 2U);
  EXPECT_EQ(chains.chains()[0].newest.p_local_m.x(), 0.2);
  EXPECT_EQ(chains.chains()[1].newest.p_local_m.x(), 0.55);
  chains.push(seen_at(1.2, {20, 0, 0}));
  EXPECT_EQ(chains.chains().size(), 3U) << "farther than a vehicle flies in a tenth of a second";
}

TEST(SightingChain, ForgetsEndedChainsAndLimitsNumber) {
  SightingChains chains;
  chains.push(seen_at(1.0, {0, 0, 0}));
  chains.push(seen_at(2.0, {50, 0, 0}));
  chains.forget_before(from_seconds(1.0));
  EXPECT_EQ(chains.chains().size(), 2U);
  chains.forget_before(from_seconds(1.0) + 1);
  ASSERT_EQ(chains.chains().size(), 1U);
  EXPECT_EQ(chains.chains()[0].newest.t, from_seconds(2.0));
  for (int i = 0; i < 400; ++i) chains.push(seen_at(2.0, {100.0 * i + 200.0, 0, 0}));
  EXPECT_LT(chains.chains().size(), 400U);
  chains.clear();
  EXPECT_TRUE(chains.chains().empty());
}

TEST(MotionMatch, SeparatesOwnFromOtherMotion) {
  const Random random(4, "test.match");
  const OdometryDrift drift(no_drift());
  const Path path = eight(1.2, 0.6), other = eight(1.5, 0.35);
  constexpr double kClock_s = 0.15, kSigma_m = 0.05;
  RelativeOdometry odometry;
  for (int i = 0; i <= 20; ++i) {
    const double t_s = 0.5 * i;
    OtherMotion motion;
    motion.t = from_seconds(t_s);
    motion.p_other_local_m = turned_by(1.0) * path(t_s);
    motion.v_other_local_mps = turned_by(1.0) * (path(t_s + 1e-4) - path(t_s - 1e-4)) / 2e-4;
    odometry.push(motion);
  }
  const auto match_of = [&](const Path& seen_path, double gap_max_s) {
    std::vector<Sighting> seen;
    for (std::uint32_t i = 0; i < 28; ++i) {
      const double t_s = 0.31 + 0.35 * i;
      const auto n = random.normal3(i, 0);
      seen.push_back(seen_at(t_s, seen_path(t_s - kClock_s) + kSigma_m * Vector3(n[0], n[1], n[2])));
      seen.back().covariance = kSigma_m * kSigma_m * Matrix3::Identity();
    }
    return match_motion(seen, odometry, drift, kClock_s, gap_max_s);
  };
  const MotionMatch own = match_of(path, 2.0);
  EXPECT_GT(own.count, 20);
  EXPECT_NEAR(own.residual_sigma, 1.0, 0.4);
  EXPECT_GT(own.spread_m, 0.5);
  EXPECT_GT(match_of(other, 2.0).residual_sigma, 3.0);
  EXPECT_GT(match_of(rest(), 2.0).residual_sigma, 3.0);
  EXPECT_EQ(match_of(path, 0.4).count, 0) << "all lies in gaps";
  EXPECT_EQ(match_motion(std::vector<Sighting>{seen_at(1, {0, 0, 0})}, {}, drift, 0.0, 2.0).count, 0);
}

// ---- the stage

constexpr VehicleId kMate = 1;

Message report_of(TimeNs t, const Vector3& p_m, const Vector3& v_mps = Vector3::Zero(), double yaw_rad = 0.0,
                  double rate_radps = 0.0) {
  OtherMotion motion;
  motion.p_other_local_m = p_m;
  motion.v_other_local_mps = v_mps;
  motion.yaw_rad = yaw_rad;
  motion.yaw_rate_radps = rate_radps;
  return odometry_message(motion, kMate, t, t);
}

struct Stage {
  Module module{relative_localizer_module_types(), "sliding_window"};
  std::unique_ptr<RelativeLocalizer> localizer;
  StateEstimate estimate;
  LocalPoses poses;
  Outbox outbox{0};

  Stage(const char* type = "sliding_window") : module(relative_localizer_module_types(), type) {}
  std::vector<RelativeEstimate> step(TimeNs t, const std::vector<Message>& messages,
                                     std::span<const Detection> detections, std::span<const Track> tracks = {}) {
    if (!localizer) {
      AgentSetup setup;
      setup.vehicle_names = {"uav1", "uav2", "uav3"};
      setup.num_vehicles = 3;
      localizer = make_relative_localizer(module, setup);
    }
    estimate.valid = true;
    estimate.t = t;
    poses.push(estimate);
    Observation observation;
    observation.t = t;
    observation.messages = messages;
    std::vector<RelativeEstimate> found;
    localizer->step({.observation = observation,
                     .estimate = estimate,
                     .poses = poses,
                     .detections = detections,
                     .has_tracks = !tracks.empty(),
                     .tracks = tracks},
                    found, outbox);
    return found;
  }
  /// Pairs in the window.
  std::vector<Eigen::Vector3f> window() const {
    std::vector<Overlay> overlays;
    localizer->append_overlays(overlays);
    return overlays.at(2).positions;
  }
};

Detection bright_at(TimeNs t, const Vector3& p_m, double reflectivity = 18.0) {
  Detection d;
  d.t = t;
  d.position_m = p_m;
  d.covariance = 0.01 * Matrix3::Identity();
  d.reflectivity = reflectivity;
  return d;
}

TEST(RelativeStage, OffsetsTeammateBehindAndAboveSightings) {
  Stage stage;
  auto& config = stage.module.as<SlidingWindowConfig>();
  config.source = SlidingWindowConfig::Source::kDetections;
  config.center_behind_m = 0.2;
  config.center_above_m = 0.1;
  stage.estimate.T_local_body = make_pose({1, 1, 0}, Eigen::Quaterniond::Identity());
  const TimeNs s = kNsPerSecond;
  stage.step(s, {report_of(s, {0, 0, 0})}, {});
  const std::vector<Detection> detections = {bright_at(s + s / 2, {4, 5, 0}), bright_at(s + s / 2, {9, 9, 9}, 0.5)};
  stage.step(s + s / 2, {}, detections);
  EXPECT_TRUE(stage.window().empty()) << "its odometry has not arrived";
  stage.step(2 * s, {report_of(2 * s, {1, 0, 0})}, {});
  const auto window = stage.window();
  ASSERT_EQ(window.size(), 1U) << "the dim one has no marker";
  EXPECT_LT((window[0] - Eigen::Vector3f(4.0F + 0.2F * 0.6F, 5.0F + 0.2F * 0.8F, 0.1F)).norm(), 1e-5F);
}

TEST(RelativeStage, RetainsDimmedTracksForAWhile) {
  const auto pairs_after_s = [](double dim_for_s, double reflectivity) {
    Stage stage;
    auto& config = stage.module.as<SlidingWindowConfig>();
    config.alignment.window_step_m = 0.0;
    config.odometry_gap_max_s = 20.0;
    const TimeNs s = kNsPerSecond;
    stage.step(s, {report_of(s, {0, 0, 0})}, {});
    Track track;
    track.id = 7;
    track.corrected = true;
    track.measured_m = {3, 0, 0};
    const auto see = [&](TimeNs t, double brightest, bool corrected) {
      track.t = t;
      track.reflectivity = brightest;
      track.corrected = corrected;
      stage.step(t, {}, {}, {&track, 1});
    };
    see(s + s / 2, reflectivity, true);
    see(s + s / 2 + from_seconds(0.5 * dim_for_s), 0.3, false);  // not seen
    see(s + s / 2 + from_seconds(dim_for_s), 0.3, true);
    stage.step(9 * s, {report_of(9 * s, {1, 0, 0})}, {});
    return stage.window().size();
  };
  EXPECT_EQ(pairs_after_s(1.0, 18.0), 2U);
  EXPECT_EQ(pairs_after_s(5.0, 18.0), 1U);
  EXPECT_EQ(pairs_after_s(1.0, 0.5), 0U);
}

TEST(RelativeStage, TrustsSharedWorldForTwoSeconds) {
  Stage stage("shared_world");
  stage.estimate.correct(make_pose({10, 0, 0}, Eigen::Quaterniond::Identity()));
  auto& config = stage.module.as<SharedWorldConfig>();
  config.sigma_m = 0.3;
  config.yaw_sigma_deg = 4.0;
  const TimeNs s = kNsPerSecond;
  stage.step(s, {report_of(s, {1, 2, 3}, {0.5, -1, 0}, 3.0, 0.4)}, {});
  for (const TimeNs after : {s / 2, 2 * s}) {
    const auto found = stage.step(s + after, {}, {});
    ASSERT_EQ(found.size(), 1U);
    const RelativeEstimate& e = found[0];
    const double since_s = to_seconds(after);
    EXPECT_EQ(e.other, kMate);
    EXPECT_EQ(e.t, s + after);
    EXPECT_LT((e.position_m - (Vector3(-9, 2, 3) + since_s * Vector3(0.5, -1, 0))).norm(), 1e-9);
    EXPECT_LT((e.velocity_mps - Vector3(0.5, -1, 0)).norm(), 1e-12);
    EXPECT_NEAR(std::remainder(e.yaw_rad - 3.0 - 0.4 * since_s, 2.0 * kPi), 0.0, 1e-9);
    EXPECT_LE(std::abs(e.yaw_rad), kPi);
    RelativeEstimate::Covariance expected = RelativeEstimate::Covariance::Zero();
    expected.diagonal().head<6>().setConstant(0.09);
    expected(6, 6) = std::pow(4.0 * kRadPerDeg, 2);
    EXPECT_LT((e.covariance - expected).norm(), 1e-12);
    EXPECT_EQ(e.seen, s);
    EXPECT_EQ(e.report_t, s);
    EXPECT_EQ(e.report_stamp, s);
    EXPECT_LT((e.report_position_m - Vector3(-9, 2, 3)).norm(), 1e-9);
    EXPECT_NEAR(e.report_yaw_rad, 3.0, 1e-9);
  }
  EXPECT_TRUE(stage.step(3 * s + 1, {}, {}).empty());
}

/// A teammate reported and seen along a figure eight until it is localized.
struct KnownMate {
  SlidingWindowConfig config;
  Teammate mate;
  TimeNs t = 0;
  explicit KnownMate(const SlidingWindowConfig& its_config) : config(its_config), mate(kMate, its_config) {
    const Path path = eight(1.2, 0.8);
    for (int i = 0; !mate.known() && i < 200; ++i) {
      const double t_s = 1.0 + 0.1 * i;
      t = from_seconds(t_s);
      bool has_report = false;
      if (i % 5 == 0) {
        const std::vector<Message> messages = {report_of(t, path(t_s), (path(t_s + 1e-4) - path(t_s - 1e-4)) / 2e-4)};
        has_report = mate.receive(messages);
      }
      mate.wait({t, path(t_s), 0.0025 * Matrix3::Identity()});
      mate.update(has_report);
    }
  }
};

TEST(Teammate, IsLostAfterProlongedAmbiguity) {
  SlidingWindowConfig config;
  config.reacquire_s = 2.0;
  config.clock_sigma_s = 0.0;
  for (const TimeNs more : {TimeNs{0}, TimeNs{1}}) {
    KnownMate known(config);
    ASSERT_TRUE(known.mate.known());
    EXPECT_EQ(known.mate.num_starts(), 1U);
    known.mate.mark_ambiguous(known.t + 2 * kNsPerSecond + more);
    EXPECT_EQ(known.mate.known(), more == 0);
    EXPECT_EQ(known.mate.num_lost(), more == 0 ? 0U : 1U);
  }
}

TEST(Teammate, IsReportedWhileSufficientlyCertain) {
  SlidingWindowConfig config;
  KnownMate known(config);
  ASSERT_TRUE(known.mate.known());
  const auto e = known.mate.estimate(known.t);
  ASSERT_TRUE(e);
  EXPECT_EQ(e->other, kMate);
  EXPECT_LT((known.mate.place_local_m() - e->position_m).norm(), 1e-12);
  // Without further data the largest deviation grows by white acceleration up to its limit.
  double s = 0.0, greatest_m = 0.0;
  for (; s < 60.0; s += 0.02) {
    const auto later = known.mate.estimate(known.t + from_seconds(s));
    if (!later) break;
    greatest_m = std::sqrt(Matrix3(later->covariance.topLeftCorner<3, 3>()).eigenvalues().real().maxCoeff());
    EXPECT_LE(greatest_m, 1.0);
  }
  EXPECT_GT(greatest_m, 0.5);
  EXPECT_FALSE(known.mate.known());
  EXPECT_EQ(known.mate.num_lost(), 1U);
  EXPECT_FALSE(known.mate.estimate(known.t));
}

}  // namespace
}  // namespace swiftlet
