// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/track_before_detect.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "core/detection/air_map.hpp"
#include "core/detection/beam_index.hpp"
#include "core/detection/existence.hpp"
#include "core/detection/hypotheses.hpp"
#include "swiftlet/core/stage_tables/detectors.hpp"
#include "tests/core/detection/detection_support.hpp"

namespace swiftlet {
namespace {

using namespace testing;
constexpr TimeNs kTick = 4'000'000;
constexpr TimeNs kTurn = 100'000'000;

// 20 of 100 objects are targets. 9 of 10 targets and 1 of 10 other objects give the measurement: 18 of 26 measurements.
TEST(Existence, IsBayesRule) {
  EXPECT_NEAR(existence_after(0.2, 0.9 / 0.1), 18.0 / 26.0, 1e-12);
  EXPECT_NEAR(existence_after(0.2, 0.1 / 0.9), 2.0 / 74.0, 1e-12);
  EXPECT_DOUBLE_EQ(existence_after(0.3, 1.0), 0.3);
  EXPECT_DOUBLE_EQ(existence_after(0.0, 100.0), 0.0);
  EXPECT_DOUBLE_EQ(existence_after(1.0, 0.01), 1.0);
}

// The integral of exp(-rate n) over the gamma distribution of shape a and mean m is (a / (a + m n))^a.
TEST(Existence, AveragesPoissonSilenceOverGammaDistribution) {
  const ReturnRate rate{.returns = 3.0, .shots = 10.0, .variation = 2.0};
  constexpr int kSteps = 200000;
  constexpr double kStep = 1e-4, kShots = 7.0;
  const double theta = rate.mean() / rate.variation;  // scale
  double integral = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double x = (i + 0.5) * kStep;
    integral += kStep * x * std::exp(-x / theta) / (theta * theta) * std::exp(-x * kShots);
  }
  EXPECT_NEAR(rate.p_no_return(kShots), integral, 1e-6);
  EXPECT_DOUBLE_EQ(rate.p_no_return(0.0), 1.0);
}

// 20 of 100 targets are hidden. A visible one is silent in one of four sweeps: 20 and 20 remain.
TEST(Existence, SilenceFavorsHiddenOverGone) {
  Observability sight{.hidden = 0.2};
  EXPECT_NEAR(sight.weigh(0.25), 0.4, 1e-12);
  EXPECT_NEAR(sight.hidden, 0.5, 1e-12);
  double existence = 0.9;
  for (int i = 0; i < 200; ++i) existence = existence_after(existence, sight.weigh(0.25));
  EXPECT_NEAR(sight.hidden, 1.0, 1e-9);
  EXPECT_NEAR(existence, 0.9 * 0.5 / (0.1 + 0.9 * 0.5), 1e-9) << "only hidden targets remain";
}

// Seen for 4 s and hidden for 1 s in the mean: a fifth of the time in the long run.
TEST(Existence, RelaxesToLongRunHiddenShare) {
  Observability sight;
  sight.predict(100.0, 0.25, 1.0);
  EXPECT_NEAR(sight.hidden, 0.2, 1e-12);
  sight.hidden = 1.0;
  double plainly = 1.0;
  for (int i = 0; i < 100000; ++i) plainly += 1e-5 * (0.25 * (1.0 - plainly) - 1.0 * plainly);
  sight.predict(1.0, 0.25, 1.0);
  EXPECT_NEAR(sight.hidden, plainly, 1e-5);
}

TEST(Existence, TheRateOfReturnsIsLearned) {
  ReturnRate rate{.returns = 2.0, .shots = 8.0};
  for (int i = 0; i < 200; ++i) rate.update(3, 6.0, 0.95);
  EXPECT_NEAR(rate.mean(), 0.5, 1e-4);
}

TEST(AirMap, EstimatesClutterShareByBetaMean) {
  AirMapConfig config;
  config.size_m = {8.0, 8.0, 8.0};
  config.prior_hits = 0.125;
  config.prior_passes = 0.375;
  AirMap map(config);
  map.follow(Vector3::Zero());
  const Vector3 p_m(1.25, 0.25, 0.25);
  EXPECT_DOUBLE_EQ(map.clutter_share(p_m), 0.25);
  for (int i = 0; i < 6; ++i) map.pass({-3.0, 0.25, 0.25}, {3.0, 0.25, 0.25});
  map.hit(p_m, 1.0);
  map.hit(p_m, 0.5);
  EXPECT_DOUBLE_EQ(map.clutter_share(p_m), (0.125 + 1.5) / (0.125 + 1.5 + 0.375 + 6.0));
  EXPECT_DOUBLE_EQ(map.clutter_share({1.25, 0.75, 0.25}), 0.25) << "without beams";
}

// A voxel by the number of times that a dense sampling of the ray meets it: all of them and no other.
TEST(AirMap, RayPassesVoxelsAlongItsPath) {
  AirMapConfig config;
  config.size_m = {8.0, 8.0, 8.0};
  AirMap map(config);
  const Vector3 from_m(-3.3, 2.1, -1.7), to_m(2.9, -3.4, 3.1);
  map.follow(Vector3::Zero());
  map.pass(from_m, to_m);
  const double unknown = map.prior_share();
  int passed = 0;
  for (double x = -3.75; x < 4.0; x += 0.5) {
    for (double y = -3.75; y < 4.0; y += 0.5) {
      for (double z = -3.75; z < 4.0; z += 0.5) passed += map.clutter_share({x, y, z}) < unknown;
    }
  }
  for (int i = 0; i <= 10000; ++i) {
    EXPECT_LT(map.clutter_share(from_m + i / 10000.0 * (to_m - from_m)), unknown) << i;
  }
  const Cell apart = ((to_m / 0.5).array().floor() - (from_m / 0.5).array().floor()).abs().matrix().cast<int>();
  EXPECT_EQ(passed, apart.sum() + 1) << "one more for each border that is crossed";
}

TEST(AirMap, WhatEntersTheBoxIsUnknown) {
  AirMapConfig config;
  config.size_m = {8.0, 8.0, 8.0};
  AirMap map(config);
  map.follow(Vector3::Zero());
  map.pass({-3.9, 0.25, 0.25}, {3.9, 0.25, 0.25});
  map.follow({2.0, 0.0, 0.0});
  EXPECT_LT(map.clutter_share({3.75, 0.25, 0.25}), map.prior_share()) << "still there";
  EXPECT_DOUBLE_EQ(map.clutter_share({5.75, 0.25, 0.25}), map.prior_share()) << "new, where -2.25 was";
  EXPECT_DOUBLE_EQ(map.clutter_share({-3.75, 0.25, 0.25}), map.prior_share()) << "gone";
}

/// A frozen sweep of one beam along x.
std::shared_ptr<const LocalCloud> one_beam(float range_m) {
  auto beams = std::make_shared<BeamTable>();
  beams->rows = beams->cols = 1;
  beams->directions_lidar = {Eigen::Vector3f::UnitX()};
  beams->origins_lidar = {Eigen::Vector3f::Zero()};
  beams->column_offset_s = {0.0F};
  auto scan = std::make_shared<Scan>();
  scan->beams = beams;
  scan->range_m = {range_m};
  scan->external_poses = {{0, Pose::Identity()}};
  return cloud_of(scan);
}

TEST(BeamIndex, WeighsBeamByPositionUncertainty) {
  BeamIndex index;
  index.assign(*one_beam(0.0F));
  RoundTarget target{.p_local_m = {20.0, 0.0, 0.0}, .sigma_m = 0.0, .radius_m = 0.3};
  EXPECT_NEAR(index.exposure(target).shots, 1.0, 1e-9) << "the beam goes through its middle";
  target.sigma_m = 0.4;
  const double width_sq = 0.3 * 0.3 + 2.0 * 0.4 * 0.4;
  EXPECT_NEAR(index.exposure(target).shots, 0.09 / width_sq, 1e-9);
  target.p_local_m = {20.0, 0.5, 0.2};
  EXPECT_NEAR(index.exposure(target).shots, 0.09 / width_sq * std::exp(-0.29 / width_sq), 1e-9);
  target.p_local_m = {-20.0, 0.0, 0.0};
  EXPECT_EQ(index.exposure(target).shots, 0.0) << "behind the sensor";
}

TEST(BeamIndex, IgnoresBeamsEndingBeforeTarget) {
  BeamIndex index;
  RoundTarget target{.p_local_m = {20.0, 0.0, 0.0}, .sigma_m = 0.0, .radius_m = 0.3};
  index.assign(*one_beam(12.0F));
  EXPECT_NEAR(index.exposure(target).shots, 0.0, 1e-12);
  index.assign(*one_beam(35.0F));
  EXPECT_NEAR(index.exposure(target).shots, 1.0, 1e-9) << "a beam that passes the target's position";
  index.assign(*one_beam(19.9F));
  EXPECT_NEAR(index.exposure(target).shots, 1.0, 1e-9) << "a beam that ends on the target";

  target.sigma_m = 0.4;
  const double anywhere = 0.09 / (0.09 + 2.0 * 0.16);
  const std::pair<double, double> normal[] = {{-2.0, 0.0228}, {-1.0, 0.1587}, {0.0, 0.5}, {1.0, 0.8413}};
  for (const auto& [beyond_sigma, share] : normal) {
    index.assign(*one_beam(static_cast<float>(19.7 + 0.4 * beyond_sigma)));
    EXPECT_NEAR(index.exposure(target).shots, share * anywhere, 0.01 * anywhere) << "the near side may be nearer";
  }
}

// In every direction, including the poles and the seam of the azimuth, the index equals a walk over all beams.
TEST(BeamIndex, MatchesBruteForceBeams) {
  const auto beams = make_beams(48, 192, 89.0, -89.0);
  const auto cloud = cloud_of(scan_world(ground(-1000.0), Pose::Identity(), beams, 0));
  BeamIndex index;
  index.assign(*cloud);
  for (int k = 0; k < 200; ++k) {
    const double z = -0.995 + 1.99 * k / 199.0, azimuth = 2.4 * k, flat = std::sqrt(1.0 - z * z);
    const RoundTarget target{.p_local_m = 8.0 * Vector3(flat * std::cos(azimuth), flat * std::sin(azimuth), z),
                             .sigma_m = 0.2,
                             .radius_m = 0.3};
    const double width_sq = 0.09 + 2.0 * 0.04;
    double shots = 0.0;
    for (const Eigen::Vector3f& d : beams->directions_lidar) {
      const double along_m = target.p_local_m.dot(d.cast<double>());
      const double exponent = (target.p_local_m.squaredNorm() - along_m * along_m) / width_sq;
      if (along_m > 0.0 && exponent <= 6.25) shots += 0.09 / width_sq * std::exp(-exponent);
    }
    EXPECT_NEAR(index.exposure(target).shots, shots, 1e-3 * shots) << k;
  }
}

/// Sweeps of a coarse LiDAR that stands at 4 m height, of which few beams meet a target.
class Watcher {
 public:
  explicit Watcher(TrackBeforeDetectConfig config = {}) {
    config.air.size_m = {40.0, 40.0, 20.0};
    config.latency_s = 0.0;
    Module module(detector_module_types(), "track_before_detect");
    module.as<TrackBeforeDetectConfig>() = config;
    detector = make_detector(module, {});
    estimate_.T_local_body = pose_at({0.0, 0.0, 4.0});
    estimate_.valid = true;
  }

  /// One sweep of the world as it is then. Sweeps turn the sensor a little, so that their beams do not repeat.
  const DetectorOutput& look(const World& world) {
    const Pose T_local_lidar = pose_at({0.0, 0.0, 4.0}, 0.37 * static_cast<double>(t / kTurn));
    const auto cloud = cloud_of(scan_world(world, T_local_lidar, beams_, t, 40.0));
    Observation observation;
    observation.t = t;
    LocalPoses poses;
    estimate_.t = t;
    poses.push(estimate_);
    const std::vector<std::shared_ptr<const LocalCloud>> clouds = {cloud};
    output.clear();
    detector->step({t, estimate_, poses, clouds, observation}, output, outbox_);
    t += kTurn;
    return output;
  }

  std::unique_ptr<Detector> detector;
  DetectorOutput output;
  TimeNs t = 0;

 private:
  std::shared_ptr<const BeamTable> beams_ = make_beams(60, 200);
  StateEstimate estimate_;
  Outbox outbox_;
};

// 12 m away the sphere is met by one of these beams, by two, or by none.
TEST(TrackBeforeDetect, FollowsSparseTargetOnKnownPath) {
  Watcher watcher;
  for (int i = 0; i < 40; ++i) EXPECT_TRUE(watcher.look(ground()).detections.empty()) << i;
  int found = 0, with_returns = 0;
  std::uint32_t id = 0;
  for (int i = 0; i < 60; ++i) {
    const Vector3 p_m(12.0, -6.0 + 0.2 * i, 5.0);
    const DetectorOutput& output = watcher.look(all_of({ground(), sphere(p_m, 0.15)}));
    ASSERT_TRUE(output.has_detections);
    if (i < 25) continue;
    ASSERT_LE(output.detections.size(), 1U) << i;
    if (output.detections.empty()) continue;
    const Detection& d = output.detections.front();
    EXPECT_LT((d.position_m - p_m).norm(), 0.5) << i;
    EXPECT_GE(d.confidence, 0.5);
    ++found;
    with_returns += d.num_points > 0;
    ASSERT_EQ(watcher.detector->tracks().size(), 1U);
    const Track& track = watcher.detector->tracks().front();
    if (id == 0) id = track.id;
    EXPECT_EQ(track.id, id);
    if (i < 40) continue;
    EXPECT_LT((track.velocity_mps - Vector3(0.0, 2.0, 0.0)).norm(), 0.7) << i;
  }
  EXPECT_GE(found, 28) << "sweeps with a report, out of 35";
  EXPECT_LT(with_returns, found) << "reported in sweeps without returns as well";
}

// A bar of 2.4 m is wider than any gate of a target, so its ends begin hypotheses of their own.
TEST(TrackBeforeDetect, JoinsPartsIntoOneLargeBody) {
  Watcher watcher;
  for (int i = 0; i < 40; ++i) watcher.look(ground());
  std::set<std::uint32_t> ids;
  std::size_t most = 0;
  for (int i = 0; i < 60; ++i) {
    const Vector3 p_m(8.0, -6.0 + 0.2 * i, 5.0), half_m(0.0, 1.2, 0.0);
    const DetectorOutput& output = watcher.look(all_of({ground(), bar(p_m - half_m, p_m + half_m, 0.12)}));
    most = std::max(most, output.detections.size());
    if (i < 20) continue;
    ASSERT_EQ(output.detections.size(), 1U) << i;
    EXPECT_LT((output.detections.front().position_m - p_m).norm(), 0.4) << i;
    ids.insert(watcher.detector->tracks().front().id);
  }
  EXPECT_EQ(ids.size(), 1U);
  EXPECT_GT(most, 1U) << "largest number of detections while the body is still in parts";
}

// A bar loses its middle, and its ends fly apart: they are separate targets after a second or two.
TEST(TrackBeforeDetect, SplitsBodyProvenToBeTwo) {
  Watcher watcher;
  for (int i = 0; i < 40; ++i) watcher.look(ground());
  int one = 0, two = 0;
  for (int i = 0; i < 90; ++i) {
    const Vector3 p_m(6.0, -4.5 + 0.1 * i, 5.0), half_m(0.0, 1.2, 0.0), gap_m(0.0, 0.4, 0.0);
    const World whole = bar(p_m - half_m, p_m + half_m, 0.12);
    const World ends = all_of({bar(p_m - half_m, p_m - gap_m, 0.12), bar(p_m + gap_m, p_m + half_m, 0.12)});
    const std::size_t reported = watcher.look(all_of({ground(), i < 40 ? whole : ends})).detections.size();
    if (i >= 20 && i < 40) one += reported == 1;
    if (i >= 70) two += reported == 2;
  }
  EXPECT_EQ(one, 20);
  EXPECT_GE(two, 18) << "sweeps with two reports, out of 20";
}

// Two that come near each other, with 0.5 m between them, and fly on side by side.
TEST(TrackBeforeDetect, TwoSideBySideStayTwo) {
  Watcher watcher;
  for (int i = 0; i < 40; ++i) watcher.look(ground());
  int two = 0;
  for (int i = 0; i < 80; ++i) {
    const Vector3 p_m(8.0, -6.0 + 0.15 * i, 5.0), half_m(0.0, 0.5 * std::max(1.0, 3.0 - 0.1 * i), 0.0);
    const World pair = all_of({ground(), sphere(p_m - half_m, 0.25), sphere(p_m + half_m, 0.25)});
    const std::size_t reported = watcher.look(pair).detections.size();
    if (i >= 20) two += reported == 2;
  }
  EXPECT_GE(two, 57) << "sweeps with two reports, out of 60";
}

TEST(TrackBeforeDetect, DropsTargetThatBeamsPassThrough) {
  Watcher watcher;
  for (int i = 0; i < 40; ++i) watcher.look(ground());
  for (int i = 0; i < 30; ++i) watcher.look(all_of({ground(), sphere({10.0, 0.0, 5.0}, 0.3)}));
  ASSERT_EQ(watcher.output.detections.size(), 1U);
  int reported = 0;
  for (int i = 0; i < 15; ++i) reported += static_cast<int>(watcher.look(ground()).detections.size());
  EXPECT_LT(reported, 14) << "sweeps with a report after the target vanished, out of 15";
  EXPECT_TRUE(watcher.output.detections.empty());
}

TEST(TrackBeforeDetect, KeepsTargetHiddenBehindWall) {
  Watcher watcher;
  const World wall = bar({6.0, -0.2, -2.0}, {6.0, -0.2, 9.0}, 1.2);
  const auto target = [](double y) { return sphere({12.0, y, 5.0}, 0.3); };
  for (int i = 0; i < 40; ++i) watcher.look(all_of({ground(), wall}));
  for (int i = 0; i < 25; ++i) watcher.look(all_of({ground(), wall, target(-6.0 + 0.15 * i)}));
  ASSERT_EQ(watcher.output.detections.size(), 1U);
  const double before = watcher.output.detections.front().confidence;
  watcher.look(all_of({ground(), wall, sphere({12.0, 0.0, -50.0}, 0.1)}));  // gone where beams look
  ASSERT_EQ(watcher.output.detections.size(), 1U) << "one sweep alone decides nothing";
  EXPECT_LT(watcher.output.detections.front().confidence, before);
}

/// A target that passes behind a pillar for 3.2 s. Gives its identity before and after; 0: none.
struct BehindAPillar {
  BehindAPillar() {
    for (int i = 0; i < 40; ++i) watcher.look(all_of({ground(), pillar}));
    for (int i = 0; i < 15; ++i) look(i);
    before = identity();
  }
  /// One sweep, optionally with another object.
  void look(int i, const World& other = ground()) {
    watcher.look(all_of({ground(), pillar, other, sphere(place_m(i), 0.3)}));
  }
  static Vector3 place_m(int i) { return {12.0, -6.0 + 0.2 * i, 5.0}; }
  std::uint32_t identity() const {
    return watcher.detector->tracks().empty() ? 0 : watcher.detector->tracks().front().id;
  }

  Watcher watcher;
  World pillar = bar({5.0, 0.0, -2.0}, {5.0, 0.0, 20.0}, 1.2);
  std::uint32_t before = 0;
};

TEST(TrackBeforeDetect, KeepsIdentityOfHiddenTarget) {
  BehindAPillar flight;
  ASSERT_NE(flight.before, 0U);
  int hidden = 0, found_after = -1;
  for (int i = 15; i < 60; ++i) {
    flight.look(i);
    ASSERT_LE(flight.watcher.detector->tracks().size(), 1U) << i;
    hidden += flight.identity() == 0;
    if (hidden == 0 || flight.identity() == 0) continue;
    EXPECT_EQ(flight.identity(), flight.before) << i;
    if (found_after < 0) found_after = i;
    if (i < found_after + 5) continue;
    const Track& track = flight.watcher.detector->tracks().front();
    EXPECT_LT((track.velocity_mps - Vector3(0.0, 2.0, 0.0)).norm(), 0.8) << i;
  }
  EXPECT_GT(hidden, 10) << "too uncertain to report";
  ASSERT_GT(found_after, 0);
  EXPECT_LE(found_after, 49) << "first sweep with a report after the pillar, which hides the target until sweep 46";
}

// No target flies 24 m in 2 s. So the detection is a new target, and the hidden one keeps its identity.
TEST(TrackBeforeDetect, NewTargetElsewhereGetsNewIdentity) {
  BehindAPillar flight;
  ASSERT_NE(flight.before, 0U);
  const auto other_m = [](int i) { return Vector3(-11.0, 8.0 - 0.15 * i, 6.0); };
  std::uint32_t other = 0;
  for (int i = 15; i < 60; ++i) {
    flight.look(i, i < 35 ? ground() : sphere(other_m(i), 0.3));
    for (const Track& track : flight.watcher.detector->tracks()) {
      const bool is_other = i >= 35 && (track.position_m - other_m(i)).norm() < 1.0;
      EXPECT_NE(is_other, track.id == flight.before) << i;
      if (is_other) other = track.id;
    }
  }
  EXPECT_NE(other, 0U);
  EXPECT_EQ(flight.watcher.detector->tracks().size(), 2U);
}

// Air that is free all around returns little but targets. One return may be of anything, two in a row are a target.
TEST(TrackBeforeDetect, DetectsTwoReturnsAmidFreeAir) {
  Watcher watcher;
  for (int i = 0; i < 40; ++i) watcher.look(ground());
  int looks = 0;
  for (int i = 0; i < 10 && watcher.output.detections.empty(); ++i, ++looks) {
    watcher.look(all_of({ground(), sphere({10.0, -2.0 + 0.2 * i, 5.0}, 0.3)}));
  }
  EXPECT_LE(looks, 2);
}

// A stationary object in unknown space is background, and so is what is beside it.
TEST(TrackBeforeDetect, WhatStandsStillIsNoTarget) {
  Watcher watcher;
  const World scene = all_of({ground(), bar({9.0, 0.0, 0.0}, {9.0, 0.0, 7.0}, 0.05), sphere({-8.0, 3.0, 6.0}, 0.4)});
  for (int i = 0; i < 80; ++i) EXPECT_TRUE(watcher.look(scene).detections.empty()) << i;
}

TEST(TrackBeforeDetect, ReportsDetectionsAfterItsLatency) {
  TrackBeforeDetectConfig config;
  config.latency_s = 0.05;
  Module module(detector_module_types(), "track_before_detect");
  module.as<TrackBeforeDetectConfig>() = config;
  const auto detector = make_detector(module, {});
  const auto cloud = one_beam(5.0F);
  StateEstimate estimate;
  estimate.valid = true;
  LocalPoses poses;
  poses.push(estimate);
  Observation observation;
  Outbox outbox;
  DetectorOutput output;
  for (TimeNs t = 0; t <= 48'000'000; t += kTick) {
    std::vector<std::shared_ptr<const LocalCloud>> clouds;
    if (t == 0) clouds.push_back(cloud);
    detector->step({t, estimate, poses, clouds, observation}, output, outbox);
    EXPECT_FALSE(output.has_detections) << t;
  }
  detector->step({52'000'000, estimate, poses, {}, observation}, output, outbox);
  EXPECT_TRUE(output.has_detections);
  EXPECT_EQ(output.stamp, cloud->stamp());
}

TEST(TrackBeforeDetect, ItsWorkIsBounded) {
  TrackBeforeDetectConfig config;
  config.air.size_m = {40.0, 40.0, 20.0};
  config.max_hypotheses = 3;
  Hypotheses hypotheses(config);
  const auto beams = make_beams(60, 200);
  for (int i = 0; i < 60; ++i) {
    std::vector<World> worlds = {ground()};
    if (i >= 40) {
      for (int k = 0; k < 8; ++k) {
        const double azimuth = 0.25 * std::numbers::pi * k + 0.02 * i;
        worlds.push_back(sphere({9.0 * std::cos(azimuth), 9.0 * std::sin(azimuth), 5.0}, 0.3));
      }
    }
    hypotheses.take(*cloud_of(scan_world(all_of(worlds), pose_at({0.0, 0.0, 4.0}), beams, i * kTurn, 40.0)));
    EXPECT_LE(hypotheses.all().size(), 3U);
  }
  std::vector<Counter> counters;
  hypotheses.append_counters(counters);
  ASSERT_EQ(counters.size(), 1U);
  EXPECT_GT(counters.front().count, 0U);
  EXPECT_LE(counters.front().count, counters.front().of) << "each was born before";
}

}  // namespace
}  // namespace swiftlet
