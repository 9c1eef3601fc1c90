// SPDX-License-Identifier: BSD-3-Clause
// Pose of another observer's frame from targets that both track.
#include "core/shared_tracks/frame_link.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "tests/core/shared_tracks/sharing_support.hpp"

namespace swiftlet {
namespace {

struct LinkTrial {
  std::vector<Flyer> targets = {target_1(), target_2(), target_3()};
  std::vector<int> a_sees = {0, 1, 2}, b_sees = {0, 1, 2};  // indices of targets
  bool a_sees_b = true, b_sees_a = true;
  double sigma_m = 0.1;
  double duration_s = 40.0;
  double loss = 0.0;  // share of lost messages of B
  OdometryDriftConfig drift = no_drift();
  FrameLinkConfig config;
  Flyer a = observer_a(), b = observer_b();
};

/// Both fly, and A compares.
class LinkFlight {
 public:
  LinkFlight(const LinkTrial& trial, std::uint64_t seed)
      : trial_(trial),
        a_(trial.a, trial.drift, seed, "a"),
        b_(trial.b, trial.drift, seed, "b"),
        link_(trial.config, trial.drift),
        radio_(seed, "test.link", "radio") {}

  void fly() {
    while (a_.t_s() < trial_.duration_s) step();
  }

  void step() {
    own_.push_self(a_.t(), a_.p_local_m(), a_.v_local_mps(), a_.yaw_local_world_rad(), 0.02);
    for (const int k : trial_.a_sees) see(own_, a_, trial_.targets[static_cast<std::size_t>(k)], k + 1);
    if (trial_.a_sees_b) see(own_, a_, b_.flyer, 9);
    own_.complete_until(a_.t());
    if (++count_ % 2 == 0 && radio_.uniform(count_, 0) >= trial_.loss) {  // five times a second
      received_.push_self(b_.t(), b_.p_local_m(), b_.v_local_mps(), b_.yaw_local_world_rad(), 0.02);
      for (const int k : trial_.b_sees) see(received_, b_, trial_.targets[static_cast<std::size_t>(k)], k + 101);
      if (trial_.b_sees_a) see(received_, b_, a_.flyer, 109);
      received_.complete_until(b_.t());
    }
    own_.forget_before(a_.t() - from_seconds(15.0));
    received_.forget_before(a_.t() - from_seconds(15.0));
    link_.update(own_, received_);
    if (link_.alignment()) known_from_s_ = std::min(known_from_s_, a_.t_s());
    a_.step();
    b_.step();
  }

  FrameLink& link() { return link_; }
  double known_from_s() const { return known_from_s_; }
  /// Error of the position of B's anchor and of the heading.
  Eigen::Matrix<double, 4, 1> error() const {
    const FrameAlignment& found = *link_.alignment();
    Eigen::Matrix<double, 4, 1> e;
    e << found.anchor_local_m - a_.from(b_, found.anchor_other_m),
        std::remainder(found.yaw_rad - a_.yaw_from(b_), 2.0 * kPi);
    return e;
  }

 private:
  void see(ObserverHistory& history, const DriftingObserver& observer, const Flyer& what, int identity) const {
    const MotionEstimate seen = observer.seen(what, static_cast<std::uint32_t>(identity), trial_.sigma_m, 0.3);
    history.push_track(static_cast<std::uint32_t>(identity), observer.t(), seen.p_m(), seen.v_mps(),
                       seen.covariance.topLeftCorner<3, 3>());
  }

  LinkTrial trial_;
  DriftingObserver a_, b_;
  ObserverHistory own_, received_;
  FrameLink link_;
  Random radio_;
  std::uint32_t count_ = 0;
  double known_from_s_ = 1e9;
};

TEST(FrameLink, FindsKnownFrameFromCommonTargets) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    LinkFlight flight({}, seed);
    flight.fly();
    ASSERT_TRUE(flight.link().alignment()) << seed;
    EXPECT_LT(flight.error().head<3>().norm(), 0.1) << seed;
    EXPECT_LT(std::abs(flight.error()(3)), 0.5 * kRadPerDeg) << seed;
    EXPECT_LT(flight.known_from_s(), 12.0) << seed;
    EXPECT_EQ(flight.link().num_starts(), 1U) << seed;
  }
}

LinkTrial formation_of_two() {
  LinkTrial trial;
  Flyer beside = target_1();
  beside.middle_m.x() += 3.0;
  trial.targets = {target_1(), beside};
  trial.a_sees = trial.b_sees = {0, 1};
  trial.a_sees_b = trial.b_sees_a = false;
  return trial;
}

TEST(FrameLink, FindsFrameFromLittleEvidence) {
  LinkTrial mutual, lossy;
  mutual.a_sees = mutual.b_sees = {};
  lossy.loss = 0.5;
  lossy.config.gap_max_s = 1.0;
  const std::pair<const char*, LinkTrial> trials[] = {
      {"mutual sightings", mutual}, {"half of the messages", lossy}, {"formation that both see", formation_of_two()}};
  for (const auto& [name, trial] : trials) {
    LinkFlight flight(trial, 3);
    flight.fly();
    ASSERT_TRUE(flight.link().alignment()) << name;
    EXPECT_LT(flight.error().head<3>().norm(), 0.2) << name;
  }
}

TEST(FrameLink, FindsFrameFromOneTargetLater) {
  LinkTrial trial;
  trial.a_sees = {0, 1};
  trial.b_sees = {0, 2};
  trial.a_sees_b = trial.b_sees_a = false;
  LinkFlight flight(trial, 4);
  flight.fly();
  ASSERT_TRUE(flight.link().alignment());
  EXPECT_GE(flight.known_from_s(), trial.config.alone_s);
  EXPECT_LT(flight.error().head<3>().norm(), 0.4);
}

TEST(FrameLink, FindsNoFrameWithoutCommonTargets) {
  LinkTrial trial;
  trial.a_sees = {0};
  trial.b_sees = {1, 2};
  trial.a_sees_b = trial.b_sees_a = false;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    LinkFlight flight(trial, seed);
    flight.fly();
    EXPECT_FALSE(flight.link().alignment()) << seed;
    EXPECT_EQ(flight.link().num_starts(), 0U);
  }
}

TEST(FrameLink, FindsNoFrameFromStraightFlights) {
  LinkTrial trial;
  trial.duration_s = 20.0;
  for (Flyer* flyer : {&trial.a, &trial.b}) *flyer = {flyer->middle_m, 2000.0, 0.001, 0.1};
  for (Flyer& target : trial.targets) target = {target.middle_m, 3000.0, 0.001, 0.2};
  LinkFlight flight(trial, 5);
  flight.fly();
  EXPECT_FALSE(flight.link().alignment());
}

TEST(FrameLink, RefusesAmbiguousFormation) {
  LinkTrial trial = formation_of_two();
  trial.b_sees = {0};
  LinkFlight flight(trial, 6);
  flight.fly();
  EXPECT_FALSE(flight.link().alignment());
}

TEST(FrameLink, FollowsTheDriftOfBoth) {
  LinkTrial trial;
  trial.drift = {};  // drift of visual-inertial odometry
  trial.duration_s = 120.0;
  double error_m = 0.0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    LinkFlight flight(trial, seed);
    flight.fly();
    ASSERT_TRUE(flight.link().alignment()) << seed;
    error_m += flight.error().head<3>().norm() / 8.0;
  }
  EXPECT_LT(error_m, 0.25);  // they drifted by 3 m and 5 degrees against each other
}

/// Without errors common to all sightings, errors match the reported covariance: four degrees of freedom.
TEST(FrameLink, ItsCovarianceIsHonest) {
  for (const bool drifts : {false, true}) {
    LinkTrial trial;
    if (drifts) trial.drift = {};
    trial.config.sigma_common_m = 1e-4;
    double nees = 0.0;
    constexpr int kFlights = 30;
    for (std::uint64_t seed = 1; seed <= kFlights; ++seed) {
      LinkFlight flight(trial, 100 + seed);
      flight.fly();
      ASSERT_TRUE(flight.link().alignment()) << seed;
      const Eigen::Matrix<double, 4, 1> e = flight.error();
      nees += e.dot(flight.link().alignment()->covariance.ldlt().solve(e)) / kFlights;
    }
    // The mean of 30 with four degrees of freedom has the deviation sqrt(8 / 30) = 0.52.
    EXPECT_GT(nees, 2.0) << drifts;
    EXPECT_LT(nees, 5.5) << drifts;
  }
}

TEST(FrameLink, TransformsMovingPointWithUncertainty) {
  FrameAlignment alignment;
  alignment.anchor_other_m = {10, 0, 0};
  alignment.anchor_local_m = {1, 2, 3};
  alignment.yaw_rad = 0.5 * kPi;
  alignment.covariance.setZero();
  alignment.covariance(3, 3) = 1e-4;
  MotionEstimate in_other;
  in_other.mean << 15, 0, 0, 2, 0, 0;
  in_other.covariance = 0.01 * Matrix6::Identity();
  in_other.covariance(0, 0) = 0.04;
  const MotionEstimate local = in_own_frame(alignment, in_other);
  EXPECT_LT((local.p_m() - Vector3(1, 7, 3)).norm(), 1e-12);
  EXPECT_LT((local.v_mps() - Vector3(0, 2, 0)).norm(), 1e-12);
  EXPECT_NEAR(local.covariance(1, 1), 0.04, 1e-12);                // its own along x is along y here
  EXPECT_NEAR(local.covariance(0, 0), 0.01 + 25.0 * 1e-4, 1e-12);  // 5 m from the anchor
  EXPECT_NEAR(local.covariance(3, 3), 0.01 + 4.0 * 1e-4, 1e-12);
  EXPECT_NEAR(local.covariance(0, 3), 10.0 * 1e-4, 1e-12);
}

TEST(SampledPath, BetweenTwoSamplesLiesACubic) {
  SampledPath path;
  const auto p = [](double t) { return Vector3(1 + 2 * t + 3 * t * t - t * t * t, -t, t * t); };
  const auto v = [](double t) { return Vector3(2 + 6 * t - 3 * t * t, -1, 2 * t); };
  for (const double t : {0.0, 0.5}) path.push({from_seconds(t), p(t), v(t), Matrix3::Identity(), 0.0, {}});
  EXPECT_LT((path.at(from_seconds(0.2), 1.0)->p_local_m - p(0.2)).norm(), 1e-12);
  EXPECT_FALSE(path.at(from_seconds(0.2), 0.4));
  EXPECT_FALSE(path.at(from_seconds(0.6), 1.0));
  EXPECT_FALSE(path.push({from_seconds(0.3), {}, {}, {}, 0.0, {}}));
}

}  // namespace
}  // namespace swiftlet
