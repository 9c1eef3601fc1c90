// SPDX-License-Identifier: BSD-3-Clause
// The filter of another vehicle's place against a plain Kalman filter that takes everything in once more at every
// question, and what another vehicle's odometry says between its samples.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "swiftlet/core/localization/relative_filter.hpp"
#include "tests/core/localization/relative_support.hpp"

namespace swiftlet {
namespace {

using Vector10 = Eigen::Matrix<double, 10, 1>;
using Matrix10 = Eigen::Matrix<double, 10, 10>;

/// Position, velocity, where the odometry was last, and the heading of its frame.
struct PlainKalman {
  RelativeFilterConfig config;
  OdometryDrift drift;
  Vector10 x = Vector10::Zero();
  Matrix10 P = Matrix10::Zero();
  TimeNs t = 0, seen = 0;
  OtherMotion heard;

  PlainKalman(const RelativeFilterConfig& its_config, const OdometryDriftConfig& its_drift)
      : config(its_config), drift(its_drift) {}
  void start(const FrameAlignment& alignment, const OtherMotion& anchor) {
    const Vector3 v = turned_by(alignment.yaw_rad) * anchor.v_other_local_mps;
    x << alignment.anchor_local_m, v, alignment.anchor_local_m, alignment.yaw_rad;
    Eigen::Matrix<double, 10, 4> J = Eigen::Matrix<double, 10, 4>::Zero();
    J.topLeftCorner<3, 3>().setIdentity();
    J.block<3, 1>(3, 3) = Vector3::UnitZ().cross(v);
    J.bottomRows<4>().setIdentity();
    P = J * alignment.covariance * J.transpose();
    P.diagonal().head<3>().array() += std::pow(config.odometry_sigma_m, 2);
    P.diagonal().segment<3>(3).array() += std::pow(config.odometry_velocity_sigma_mps, 2);
    t = seen = anchor.t;
    heard = anchor;
  }
  void forward(TimeNs to) {
    const double dt = to_seconds(to - t);
    if (dt <= 0.0) return;
    t = to;
    Matrix10 F = Matrix10::Identity();
    F.block<3, 3>(0, 3) = dt * Matrix3::Identity();
    x = F * x;
    P = F * P * F.transpose();
    // White acceleration.
    const double q = std::pow(config.acceleration_mps2_psqrthz, 2);
    for (int i = 0; i < 3; ++i) {
      P(i, i) += q * std::pow(dt, 3) / 3.0;
      P(i, i + 3) += 0.5 * q * dt * dt;
      P(i + 3, i) += 0.5 * q * dt * dt;
      P(i + 3, i + 3) += q * dt;
    }
  }
  void measure(const Eigen::VectorXd& innovation, const Eigen::MatrixXd& H, const Eigen::MatrixXd& R) {
    const Eigen::MatrixXd S = H * P * H.transpose() + R, K = P * H.transpose() * S.inverse();
    x += K * innovation;
    P = ((Matrix10::Identity() - K * H) * P).eval();
    P = 0.5 * (P + P.transpose()).eval();
  }
  void see(const Sighting& sighting) {
    forward(sighting.t);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(3, 10);
    H.leftCols(3).setIdentity();
    measure(sighting.p_local_m - x.head<3>(), H, sighting.covariance);
    seen = std::max(seen, sighting.t);
  }
  void hear(const OtherMotion& told) {
    forward(told.t);
    const Flown flown = told.flown - heard.flown;
    const Vector3 step_other_m = told.p_other_local_m - heard.p_other_local_m;
    // Drift of the frame on the way: it walks, and turns as about the middle of the step.
    const Vector3 step_m = turned_by(x(9)) * step_other_m;
    Eigen::Matrix<double, 10, 1> turn = Vector10::Zero();
    turn.segment<3>(6) = Vector3::UnitZ().cross(-0.5 * step_m);
    turn(9) = 1.0;
    P += drift.yaw_variance_rad2(flown) * turn * turn.transpose();
    P.diagonal().segment<3>(6).array() += drift.position_variance_m2(flown);
    const Vector3 v = turned_by(x(9)) * told.v_other_local_mps;
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(6, 10);
    H.topLeftCorner(3, 3).setIdentity();
    H.block(0, 6, 3, 3) = -Matrix3::Identity();
    H.block(0, 9, 3, 1) = -Vector3::UnitZ().cross(step_m);
    H.block(3, 3, 3, 3).setIdentity();
    H.block(3, 9, 3, 1) = -Vector3::UnitZ().cross(v);
    Eigen::VectorXd innovation(6);
    innovation << x.segment<3>(6) + step_m - x.head<3>(), v - x.segment<3>(3);
    Eigen::VectorXd noise(6);
    noise.head(3).setConstant(std::pow(config.odometry_sigma_m, 2));
    noise.tail(3).setConstant(std::pow(config.odometry_velocity_sigma_mps, 2));
    measure(innovation, H, noise.asDiagonal());
    // It is anchored at this sample from now on.
    const Vector3 onward_m = turned_by(x(9)) * step_other_m;
    x.segment<3>(6) += onward_m;
    Matrix10 A = Matrix10::Identity();
    A.block<3, 1>(6, 9) = Vector3::UnitZ().cross(onward_m);
    P = A * P * A.transpose();
    heard = told;
  }
  RelativeEstimate at(TimeNs when) const {
    PlainKalman then = *this;
    then.forward(when);
    RelativeEstimate out;
    out.position_m = then.x.head<3>();
    out.velocity_mps = then.x.segment<3>(3);
    const double since_s = std::max(0.0, to_seconds(when - heard.t));
    out.yaw_rad = then.x(9) + heard.yaw_rad + since_s * heard.yaw_rate_radps;
    const int of[] = {0, 1, 2, 3, 4, 5, 9};
    for (int i = 0; i < 7; ++i) {
      for (int j = 0; j < 7; ++j) out.covariance(i, j) = then.P(of[i], of[j]);
    }
    for (int i = 0; i < 3; ++i) out.covariance(i, i) += std::pow(config.bias_sigma_m, 2);
    out.covariance(6, 6) += std::pow(config.odometry_yaw_sigma_deg * kRadPerDeg, 2) +
                            std::pow(config.yaw_rate_sigma_degps * kRadPerDeg * since_s, 2);
    return out;
  }
};

struct Event {
  bool is_odometry;
  TimeNs t;
  OtherMotion told;
  Sighting seen;
};

/// Sightings ten times and odometry twice a second, each at an instant of its own.
std::vector<Event> events_of(std::uint32_t seed, double duration_s) {
  const Random random(seed, "test.plain_filter", "events");
  std::vector<Event> events;
  const Path path = eight(1.5, 0.7);
  Flown flown;
  double last_s = 0.0;
  for (std::uint32_t k = 1; 0.1 * k < duration_s; ++k) {
    const bool is_odometry = k % 5 == 0;
    const double t_s = 0.1 * k + 0.02 * random.uniform(k, 0);
    Event event{is_odometry, from_seconds(t_s), {}, {}};
    const Vector3 noise(random.normal(k, 1), random.normal(k, 2), random.normal(k, 3));
    if (is_odometry) {
      flown.path_m += (path(t_s) - path(last_s)).norm();
      flown.turn_rad += 0.3 * random.uniform(k, 4);
      flown.time_s += t_s - last_s;
      last_s = t_s;
      event.told.t = event.told.stamp = event.t;
      event.told.p_other_local_m = turned_by(-0.8) * (path(t_s) - Vector3(3, 1, 0)) + 0.01 * noise;
      event.told.v_other_local_mps = turned_by(-0.8) * (path(t_s + 1e-4) - path(t_s - 1e-4)) / 2e-4;
      event.told.yaw_rad = 2.9 + 0.1 * k;
      event.told.yaw_rate_radps = 0.4;
      event.told.flown = flown;
    } else {
      event.seen = {event.t, path(t_s) + 0.05 * noise, sighting_covariance(0.04 + 0.01 * (k % 4))};
    }
    events.push_back(event);
  }
  return events;
}

struct Pair {
  PlainKalman plain;
  RelativeFilter filter;
  explicit Pair(const RelativeFilterConfig& config, const OdometryDriftConfig& drift)
      : plain(config, drift), filter(config, drift) {
    FrameAlignment start;
    start.anchor_local_m = eight(1.5, 0.7)(0.0);
    start.yaw_rad = 0.75;
    start.covariance.setZero();
    start.covariance.diagonal() << 0.004, 0.003, 0.005, 0.002;
    start.covariance(0, 3) = start.covariance(3, 0) = 0.001;
    OtherMotion anchor;
    anchor.p_other_local_m = turned_by(-0.8) * (start.anchor_local_m - Vector3(3, 1, 0));
    anchor.v_other_local_mps = {0.3, 0.9, -0.1};
    anchor.yaw_rad = 2.9;
    start.anchor_other_m = anchor.p_other_local_m;
    plain.start(start, anchor);
    filter.start(start, anchor);
  }
};

void expect_alike(const RelativeEstimate& a, const RelativeEstimate& b) {
  EXPECT_LT((a.position_m - b.position_m).norm(), 1e-9);
  EXPECT_LT((a.velocity_mps - b.velocity_mps).norm(), 1e-9);
  EXPECT_NEAR(std::remainder(a.yaw_rad - b.yaw_rad, 2.0 * kPi), 0.0, 1e-9);
  EXPECT_LE(std::abs(a.yaw_rad), kPi);
  EXPECT_LT((a.covariance - b.covariance).norm(), 1e-9 * (1.0 + b.covariance.norm()));
}

TEST(PlainFilter, TellsTheSameAfterEveryMeasurementAndBetweenThem) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    RelativeFilterConfig config;
    config.gate_sigma = 1000.0;
    config.drift_factor_max = 1.0;  // the drift is as it is said to be
    config.bias_sigma_m = 0.03;
    config.history_s = seed % 2 == 0 ? 0.5 : 60.0;
    const OdometryDriftConfig drift = {0.05, 0.1, 0.02, 0.8, 2.0, 0.3};
    Pair pair(config, drift);
    for (const Event& event : events_of(seed, 20.0)) {
      if (event.is_odometry) {
        pair.plain.hear(event.told);
        ASSERT_TRUE(pair.filter.push(event.told));
      } else {
        // Before it is taken in: how far it is from where it was expected.
        PlainKalman then = pair.plain;
        then.forward(event.t);
        const Matrix3 S = then.P.topLeftCorner<3, 3>() + event.seen.covariance;
        const Vector3 off = event.seen.p_local_m - then.x.head<3>();
        const double squared = off.dot(S.inverse() * off);
        EXPECT_NEAR(pair.filter.squared_sigmas(event.seen), squared, 1e-7 * (1.0 + squared));
        EXPECT_NEAR(pair.filter.unlikelihood(event.seen), squared + std::log(S.determinant()), 1e-6 * (1.0 + squared));
        pair.plain.see(event.seen);
        ASSERT_TRUE(pair.filter.push(event.seen));
      }
      for (const double ahead_s : {0.0, 0.07, 1.5}) {
        const TimeNs t = event.t + from_seconds(ahead_s);
        const RelativeEstimate told = pair.filter.at(t);
        expect_alike(told, pair.plain.at(t));
        EXPECT_EQ(told.t, t);
        EXPECT_EQ(told.seen, pair.plain.seen);
        EXPECT_EQ(told.heard, pair.plain.heard.t);
        EXPECT_EQ(told.heard_stamp, pair.plain.heard.stamp);
        EXPECT_LT((told.heard_position_m - pair.plain.x.segment<3>(6)).norm(), 1e-9);
        EXPECT_NEAR(std::remainder(told.heard_yaw_rad - pair.plain.x(9) - pair.plain.heard.yaw_rad, 2.0 * kPi), 0.0,
                    1e-9);
        EXPECT_LE(std::abs(told.heard_yaw_rad), kPi);
      }
      const FrameAlignment alignment = pair.filter.alignment();
      EXPECT_EQ(alignment.anchor_other_m, pair.plain.heard.p_other_local_m);
      EXPECT_LT((alignment.anchor_local_m - pair.plain.x.segment<3>(6)).norm(), 1e-9);
      EXPECT_NEAR(std::remainder(alignment.yaw_rad - pair.plain.x(9), 2.0 * kPi), 0.0, 1e-9);
      EXPECT_LT((alignment.covariance - pair.plain.P.bottomRightCorner<4, 4>()).norm(), 1e-9);
    }
    if (testing::Test::HasFailure()) break;
  }
}

TEST(PlainFilter, TakesWhatComesLateUpToItsHistoryAndNotAnOutlier) {
  RelativeFilterConfig config;
  config.history_s = 1.0;
  config.gate_sigma = 1000.0;
  const std::vector<Event> events = events_of(7, 6.0);
  Pair pair(config, no_drift());
  for (const Event& event : events) event.is_odometry ? pair.filter.push(event.told) : pair.filter.push(event.seen);
  const TimeNs newest = events.back().t;
  Sighting late = events[3].seen;
  late.t = newest - from_seconds(0.9);
  EXPECT_TRUE(pair.filter.push(late));
  late.t = newest - from_seconds(1.3);
  EXPECT_FALSE(pair.filter.push(late));
  config.gate_sigma = 4.0;
  Pair gated(config, no_drift());
  Sighting sighting;
  sighting.t = 1;
  sighting.covariance = 0.01 * Matrix3::Identity();
  const RelativeEstimate there = gated.filter.at(1);
  const double sigma_m =
      std::sqrt(there.covariance(2, 2) - std::pow(config.bias_sigma_m, 2) + sighting.covariance(2, 2));
  for (const double sigmas : {4.001, 3.999}) {
    sighting.p_local_m = there.position_m + sigmas * sigma_m * Vector3::UnitZ();
    EXPECT_NEAR(gated.filter.squared_sigmas(sighting), sigmas * sigmas, 1e-9);
    EXPECT_EQ(gated.filter.push(sighting), sigmas < 4.0);
  }
}

TEST(PlainFilter, ItsHistoryHoldsOneHundredAndTwentyEightMeasurements) {
  RelativeFilterConfig config;
  config.history_s = 60.0;
  config.gate_sigma = 1000.0;
  Pair pair(config, no_drift());
  Sighting sighting;
  sighting.p_local_m = pair.filter.at(0).position_m;
  for (int i = 1; i <= 300; ++i) {
    sighting.t = i * 1'000'000;
    ASSERT_TRUE(pair.filter.push(sighting));
  }
  // It begins after the 172nd.
  sighting.t = 172 * 1'000'000 - 1;
  EXPECT_FALSE(pair.filter.push(sighting));
  sighting.t = 172 * 1'000'000;
  EXPECT_TRUE(pair.filter.push(sighting));
}

// ---- what another vehicle told

OtherMotion told_at(double t_s, const Vector3& p_m, const Vector3& v_mps, double yaw_rad, double rate_radps) {
  OtherMotion motion;
  motion.t = from_seconds(t_s);
  motion.p_other_local_m = p_m;
  motion.v_other_local_mps = v_mps;
  motion.yaw_rad = yaw_rad;
  motion.yaw_rate_radps = rate_radps;
  return motion;
}

TEST(ToldOdometry, BetweenTwoSamplesItIsTheCubicThroughBothWithTheirVelocities) {
  // Any polynomial of third degree is told exactly; headings go the short way around, and all else evenly.
  const auto place = [](double t) {
    return Vector3(1.0 + 2.0 * t - t * t + 0.3 * t * t * t, t * t, 4.0 - 0.5 * t * t * t);
  };
  const auto velocity = [](double t) { return Vector3(2.0 - 2.0 * t + 0.9 * t * t, 2.0 * t, -1.5 * t * t); };
  RelativeOdometry odometry;
  ASSERT_TRUE(odometry.push(told_at(0.5, place(0.5), velocity(0.5), 3.0, 0.2)));
  ASSERT_TRUE(odometry.push(told_at(1.3, place(1.3), velocity(1.3), -3.0, 0.6)));
  const double turned_rad = 2.0 * kPi - 6.0, path_m = (place(1.3) - place(0.5)).norm();
  for (int i = 0; i <= 8; ++i) {
    const double t_s = 0.5 + 0.1 * i, share = i / 8.0;
    const auto told = odometry.at(from_seconds(t_s), 2.0);
    ASSERT_TRUE(told);
    EXPECT_EQ(told->t, from_seconds(t_s));
    EXPECT_LT((told->p_other_local_m - place(t_s)).norm(), 1e-9) << i;
    EXPECT_LT((told->v_other_local_mps - velocity(t_s)).norm(), 1e-9) << i;
    EXPECT_NEAR(std::remainder(told->yaw_rad - 3.0 - share * turned_rad, 2.0 * kPi), 0.0, 1e-9);
    EXPECT_NEAR(told->yaw_rate_radps, 0.2 + 0.4 * share, 1e-9);
    EXPECT_NEAR(told->flown.path_m, share * path_m, 1e-9);
    EXPECT_NEAR(told->flown.turn_rad, share * turned_rad, 1e-9);
    EXPECT_NEAR(told->flown.time_s, 0.8 * share, 1e-9);
  }
  EXPECT_FALSE(odometry.at(from_seconds(0.5) - 1, 2.0));
  EXPECT_FALSE(odometry.at(from_seconds(1.3) + 1, 2.0));
  EXPECT_TRUE(odometry.at(from_seconds(0.9), 0.81));
  EXPECT_FALSE(odometry.at(from_seconds(0.9), 0.79));
  EXPECT_TRUE(odometry.at(from_seconds(1.3), 0.1)) << "the sample itself lies in no gap";
}

TEST(ToldOdometry, AddsUpWhatWasFlownAndKeepsTheLastSixtyFour) {
  RelativeOdometry odometry;
  EXPECT_TRUE(odometry.empty());
  EXPECT_FALSE(odometry.at(0, 10.0));
  double path_m = 0.0, turn_rad = 0.0;
  for (int i = 1; i <= 100; ++i) {
    const Vector3 p_m(0.1 * i, 0.2 * (i % 2), 0.0);
    if (i > 1) {
      path_m += std::hypot(0.1, 0.2);
      turn_rad += i % 2 == 0 ? 0.4 : 0.2;
    }
    const double yaw_rad = std::remainder(3.0 + 0.3 * i + (i % 2 == 0 ? 0.1 : 0.0), 2.0 * kPi);
    ASSERT_TRUE(odometry.push(told_at(0.5 * i, p_m, Vector3::Zero(), yaw_rad, 0.0)));
    EXPECT_NEAR(odometry.newest().flown.path_m, path_m, 1e-9);
    EXPECT_NEAR(odometry.newest().flown.turn_rad, turn_rad, 1e-9);
    EXPECT_NEAR(odometry.newest().flown.time_s, 0.5 * (i - 1), 1e-9);
  }
  EXPECT_TRUE(odometry.at(from_seconds(0.5 * 37), 1.0));
  EXPECT_FALSE(odometry.at(from_seconds(0.5 * 37) - 1, 1.0));
  EXPECT_NEAR(odometry.at(from_seconds(30.25), 1.0)->flown.time_s, 29.75, 1e-9);
  EXPECT_FALSE(odometry.push(told_at(50.0, Vector3::Zero(), Vector3::Zero(), 0.0, 0.0))) << "not newer";
  for (int k = 0; k < 4; ++k) {
    OtherMotion bad = told_at(60.0, Vector3::Zero(), Vector3::Zero(), 0.0, 0.0);
    (k == 0   ? bad.p_other_local_m.x()
     : k == 1 ? bad.v_other_local_mps.y()
     : k == 2 ? bad.yaw_rad
              : bad.yaw_rate_radps) = std::nan("");
    EXPECT_FALSE(odometry.push(bad)) << k;
  }
}

TEST(ToldOdometry, ItsDriftGrowsByWayTurnsAndTime) {
  const OdometryDrift drift({0.2, 0.3, 0.4, 2.0, 3.0, 4.0});
  const double deg2 = kRadPerDeg * kRadPerDeg;
  EXPECT_NEAR(drift.position_variance_m2({5.0, 0.0, 0.0}), 0.04 * 5.0, 1e-12);
  EXPECT_NEAR(drift.position_variance_m2({0.0, 4.0 * kPi, 0.0}), 0.09 * 2.0, 1e-12);
  EXPECT_NEAR(drift.position_variance_m2({0.0, 0.0, 7.0}), 0.16 * 7.0, 1e-12);
  EXPECT_NEAR(drift.yaw_variance_rad2({5.0, 2.0 * kPi, 7.0}), (4.0 * 5.0 + 9.0 + 16.0 * 7.0) * deg2, 1e-12);
}

}  // namespace
}  // namespace swiftlet
