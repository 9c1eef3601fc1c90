// SPDX-License-Identifier: BSD-3-Clause
// Inertial navigation against a plain error-state filter: the same laws, without any of its shortcuts.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <functional>

#include "swiftlet/core/localization/ins.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/stages/estimators.hpp"

namespace swiftlet {
namespace {

using Vector16 = Eigen::Matrix<double, 16, 1>;
using Matrix16 = Eigen::Matrix<double, 16, 16>;

Matrix3 cross_of(const Vector3& v) {
  Matrix3 m;
  for (int i = 0; i < 3; ++i) m.col(i) = v.cross(Vector3::Unit(i));
  return m;
}

struct PlainIns {
  InsConfig config;
  Vector3 p, v = Vector3::Zero(), accel_bias = Vector3::Zero(), gyro_bias = Vector3::Zero();
  Matrix3 R;
  double ground;
  bool ground_known = false;
  TimeNs t = 0;
  Matrix16 P = Matrix16::Zero();

  PlainIns(const InsConfig& its_config, const Pose& start)
      : config(its_config), p(start.translation()), R(start.linear()), ground(start.translation().z()) {
    Vector16 variances;
    const double tilt = std::pow(config.start_tilt_sigma_deg * kRadPerDeg, 2);
    variances << Vector3::Constant(std::pow(config.start_position_sigma_m, 2)),
        Vector3::Constant(std::pow(config.start_velocity_sigma_mps, 2)), tilt, tilt,
        std::pow(config.start_yaw_sigma_deg * kRadPerDeg, 2),
        Vector3::Constant(std::pow(config.start_accel_bias_sigma_mps2, 2)),
        Vector3::Constant(std::pow(config.start_gyro_bias_sigma_radps, 2)), std::pow(config.start_ground_sigma_m, 2);
    P = variances.asDiagonal();
    const Matrix3 about_world_axes = P.block<3, 3>(6, 6);
    P.block<3, 3>(6, 6) = R.transpose() * about_world_axes * R;
  }
  static Matrix3 turned(const Vector3& by) {
    return by.norm() > 0.0 ? Matrix3(Eigen::AngleAxisd(by.norm(), by.normalized())) : Matrix3::Identity();
  }
  void predict(const ImuSample& sample) {
    const double dt = to_seconds(sample.t - t);
    t = sample.t;
    const Vector3 omega = sample.omega_body_radps - gyro_bias, f = sample.specific_force_body_mps2 - accel_bias;
    const Matrix3 middle = R * turned(0.5 * dt * omega);
    const Vector3 a = middle * f - Vector3(0, 0, kStandardGravity_mps2);
    p += dt * v + 0.5 * dt * dt * a;
    v += dt * a;
    R = R * turned(dt * omega);
    Matrix16 F = Matrix16::Identity();
    F.block<3, 3>(0, 3) = dt * Matrix3::Identity();
    F.block<3, 3>(3, 6) = -dt * middle * cross_of(f);
    F.block<3, 3>(3, 9) = -dt * middle;
    F.middleRows<3>(0).rightCols<10>() += 0.5 * dt * F.middleRows<3>(3).rightCols<10>();
    F.block<3, 3>(6, 6) = turned(-dt * omega);
    F.block<3, 3>(6, 12) = -dt * Matrix3::Identity();
    P = F * P * F.transpose();
    const double accel = std::pow(config.accel_noise_mps2_sqrt_hz, 2) * dt;
    for (int i = 0; i < 3; ++i) {
      P(i, i) += 0.25 * accel * dt * dt;
      P(i, i + 3) += 0.5 * accel * dt;
      P(i + 3, i) += 0.5 * accel * dt;
      P(i + 3, i + 3) += accel;
      P(i + 6, i + 6) += std::pow(config.gyro_noise_radps_sqrt_hz, 2) * dt;
      P(i + 9, i + 9) += std::pow(config.accel_walk_mps3_sqrt_hz, 2) * dt;
      P(i + 12, i + 12) += std::pow(config.gyro_walk_radps2_sqrt_hz, 2) * dt;
      if (dt > 0.1) {
        P(i, i) += std::pow(dt, 4);
        P(i + 3, i + 3) += 4.0 * dt * dt;
      }
    }
    P(15, 15) += std::pow(config.ground_walk_m_sqrt_m, 2) * std::hypot(v.x(), v.y()) * dt;
  }
  void measure(const Eigen::VectorXd& innovation, const Eigen::MatrixXd& H, const Eigen::MatrixXd& noise) {
    const Eigen::MatrixXd K = P * H.transpose() * (H * P * H.transpose() + noise).inverse();
    P = ((Matrix16::Identity() - K * H) * P).eval();
    P = 0.5 * (P + P.transpose()).eval();
    const Vector16 dx = K * innovation;
    p += dx.segment<3>(0);
    v += dx.segment<3>(3);
    R = R * turned(dx.segment<3>(6));
    accel_bias += dx.segment<3>(9);
    gyro_bias += dx.segment<3>(12);
    ground += dx(15);
  }
  Eigen::MatrixXd rows(int num) const { return Eigen::MatrixXd::Zero(num, 16); }
  void fix(const GnssSample& s) {
    Eigen::MatrixXd H = rows(3);
    H.leftCols(3).setIdentity();
    measure(s.p_world_m - p, H, s.sigma_p_m.cwiseAbs2().asDiagonal());
    H = rows(3);
    H.middleCols(3, 3).setIdentity();
    measure(s.v_world_mps - v, H, s.sigma_v_mps.cwiseAbs2().asDiagonal());
  }
  void height(const AltimeterSample& s) {
    if (!ground_known) ground = p.z() - s.height_m;
    ground_known = true;
    Eigen::MatrixXd H = rows(1);
    H(0, 2) = 1.0;
    H(0, 15) = -1.0;
    measure(Eigen::VectorXd::Constant(1, s.height_m - (p.z() - ground)), H,
            Eigen::MatrixXd::Constant(1, 1, s.sigma_m * s.sigma_m));
  }
  void heading(const CompassSample& s) {
    // By differences: how much the heading turns with a small turn about each of the body's axes.
    Eigen::MatrixXd H = rows(1);
    for (int i = 0; i < 3; ++i) {
      H(0, 6 + i) =
          std::remainder(yaw_of(R * turned(1e-6 * Vector3::Unit(i))) - yaw_of(R * turned(-1e-6 * Vector3::Unit(i))),
                         2.0 * kPi) /
          2e-6;
    }
    measure(Eigen::VectorXd::Constant(1, std::remainder(s.yaw_rad - yaw_of(R), 2.0 * kPi)), H,
            Eigen::MatrixXd::Constant(1, 1, s.sigma_rad * s.sigma_rad));
  }
  void odometry(const OdometrySample& s) {
    const Vector3 v_body = R.transpose() * v;
    Eigen::MatrixXd H = rows(3);
    H.middleCols(3, 3) = R.transpose();
    H.middleCols(6, 3) = cross_of(v_body);
    measure(s.T_local_body.linear().transpose() * s.v_local_body_mps - v_body, H,
            std::pow(config.odometry_velocity_sigma_mps, 2) * Matrix3::Identity());
  }
};

void expect_alike(const InsFilter& filter, const PlainIns& plain, int i) {
  ASSERT_LT((filter.state().p_m - plain.p).norm(), 1e-8) << i;
  ASSERT_LT((filter.state().v_mps - plain.v).norm(), 1e-8) << i;
  ASSERT_LT((filter.state().q.toRotationMatrix() - plain.R).norm(), 1e-8) << i;
  ASSERT_LT((filter.accel_bias_mps2() - plain.accel_bias).norm(), 1e-8) << i;
  ASSERT_LT((filter.gyro_bias_radps() - plain.gyro_bias).norm(), 1e-8) << i;
  ASSERT_NEAR(filter.ground_m(), plain.ground, 1e-8) << i;
  ASSERT_LT((filter.covariance() - plain.P).norm(), 1e-8 * plain.P.norm()) << i;
}

TEST(PlainIns, TellsTheSameAfterAnySequenceOfSamples) {
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    InsConfig config;
    config.gate_sigma = 1e6;
    config.accel_noise_mps2_sqrt_hz = 0.05;
    config.gyro_noise_radps_sqrt_hz = 0.01;
    config.gyro_walk_radps2_sqrt_hz = 0.003;
    const Random random(seed, "test.plain_ins");
    const auto three = [&](std::uint32_t k, std::uint32_t channel, double size) {
      const auto n = random.normal3(k, channel);
      return Vector3(size * Vector3(n[0], n[1], n[2]));
    };
    const Pose start = make_pose({3, -2, 5}, rotation_by({0.2, -0.1, 0.8}));
    PlainIns plain(config, start);
    InsFilter filter(config, start);
    for (std::uint32_t k = 1; k <= 160; ++k) {
      ImuSample imu{plain.t + (k % 40 == 0 ? 130'000'000 : 5'000'000), three(k, 0, 0.8), {}};
      imu.specific_force_body_mps2 = plain.R.transpose() * Vector3(0, 0, kStandardGravity_mps2) + three(k, 1, 2.0);
      plain.predict(imu);
      filter.predict(imu);
      if (k % 10 == 3) {
        GnssSample gnss{
            imu.t, plain.p + three(k, 2, 0.2), plain.v + three(k, 3, 0.1), {0.3, 0.4, 0.5}, {0.1, 0.2, 0.15}};
        plain.fix(gnss);
        filter.update(gnss);
      }
      if (k % 10 == 5) {
        const AltimeterSample altimeter{imu.t, plain.p.z() + 1.0 + 0.1 * random.normal(k, 4), 0.05};
        plain.height(altimeter);
        filter.update(altimeter);
      }
      if (k % 10 == 7) {
        const CompassSample compass{imu.t, yaw_of(plain.R) + 0.05 * random.normal(k, 5), 0.04};
        plain.heading(compass);
        filter.update(compass);
      }
      if (k % 10 == 9) {
        const Pose T = make_pose(three(k, 6, 5.0), rotation_by(three(k, 7, 0.5)));
        const OdometrySample odometry{imu.t, T, T.linear() * (plain.R.transpose() * plain.v + three(k, 8, 0.05))};
        plain.odometry(odometry);
        filter.update(odometry);
      }
      expect_alike(filter, plain, static_cast<int>(k));
      if (testing::Test::HasFatalFailure()) return;
    }
    EXPECT_EQ(filter.num_rejected(), 0);
    EXPECT_LT((filter.state().omega_body_radps.norm()), 10.0);
  }
}

InsFilter at_rest(const InsConfig& config) {
  InsFilter filter(config, Pose::Identity());
  for (int i = 1; i <= 10; ++i) filter.predict({i * 5'000'000, Vector3::Zero(), {0, 0, kStandardGravity_mps2}});
  return filter;
}

GnssSample fix_off_by(const InsFilter& filter, const Vector3& off_m) {
  GnssSample fix{filter.state().t, filter.state().p_m + off_m, Vector3::Constant(std::nan("")), Vector3::Constant(0.3),
                 Vector3::Ones()};
  return fix;
}

TEST(InsGate, LetsInWhatLiesWithinItsDeviationsAndNothingBeyond) {
  InsConfig config;
  config.gate_sigma = 5.0;
  for (const double times : {0.999, 1.001}) {
    InsFilter filter = at_rest(config);
    const double sigma_m = std::sqrt(filter.covariance()(2, 2) + 0.09);
    // Three numbers of a fix: the gate is that of each of them.
    filter.update(fix_off_by(filter, times * std::sqrt(3.0) * 5.0 * sigma_m * Vector3::UnitZ()));
    EXPECT_EQ(filter.num_rejected(), times > 1.0 ? 1 : 0);
    EXPECT_EQ(filter.state().p_m.z() > 0.01, times < 1.0);
    InsFilter other = at_rest(config);
    AltimeterSample first{other.state().t, 1.0, 0.1};
    other.update(first);
    const double height_sigma_m =
        std::sqrt(other.covariance()(2, 2) + other.covariance()(15, 15) - 2.0 * other.covariance()(2, 15) + 0.01);
    const double height_m = other.state().p_m.z() - other.ground_m();
    other.update(AltimeterSample{other.state().t, height_m + times * 5.0 * height_sigma_m, 0.1});
    EXPECT_EQ(other.num_rejected(), times > 1.0 ? 1 : 0);
  }
}

TEST(InsGate, WhatIsRejectedTwentyTimesInARowIsRightTheNextTime) {
  InsFilter filter = at_rest({});
  const Vector3 off_m(0, 40.0, 0);
  for (int i = 1; i <= 20; ++i) {
    filter.update(fix_off_by(filter, off_m));
    EXPECT_LT(filter.state().p_m.norm(), 0.1) << i;
    EXPECT_EQ(filter.num_rejected(), i);
  }
  filter.update(fix_off_by(filter, off_m));
  EXPECT_GT(filter.state().p_m.y(), 35.0);
  EXPECT_GT(filter.covariance()(1, 1), 0.01);
  // One that fits in between starts the count anew, and another sensor's count is its own.
  InsFilter again = at_rest({});
  for (int i = 1; i <= 20; ++i) again.update(fix_off_by(again, off_m));
  again.update(AltimeterSample{again.state().t, 1.0, 0.1});
  again.update(fix_off_by(again, Vector3::Zero()));
  for (int i = 1; i <= 20; ++i) again.update(fix_off_by(again, off_m));
  EXPECT_LT(again.state().p_m.norm(), 0.2);
  again.update(fix_off_by(again, off_m));
  EXPECT_GT(again.state().p_m.y(), 35.0);
}

TEST(InsPast, AMeasurementIsComparedWithTheStateOfTheSampleNearestToIt) {
  // At 2 m/s: a fix of the past is where the vehicle was then.
  const auto flying = [] {
    InsConfig config;
    config.start_velocity_sigma_mps = 10.0;
    InsFilter filter(config, Pose::Identity());
    filter.predict({1, Vector3::Zero(), {0, 0, kStandardGravity_mps2}});
    GnssSample speed{1, Vector3::Constant(std::nan("")), {2, 0, 0}, Vector3::Ones(), Vector3::Constant(1e-4)};
    filter.update(speed);
    for (int i = 1; i <= 300; ++i)
      filter.predict({1 + i * 10'000'000LL, Vector3::Zero(), {0, 0, kStandardGravity_mps2}});
    return filter;
  };
  const auto moved_m = [&](TimeNs t, double x_m) {
    InsFilter filter = flying();
    const double before_m = filter.state().p_m.x();
    filter.update(
        GnssSample{t, {x_m, 0, 0}, Vector3::Constant(std::nan("")), Vector3::Constant(1e-3), Vector3::Ones()});
    return filter.state().p_m.x() - before_m;
  };
  const TimeNs end = 1 + 300 * 10'000'000LL;
  EXPECT_NEAR(moved_m(end, 6.0), 0.0, 1e-3);
  EXPECT_NEAR(moved_m(end + kNsPerSecond, 6.0), 0.0, 1e-3) << "what comes too early is of now";
  for (const int samples : {1, 2, 50, 127}) {
    const double then_m = 6.0 - 0.02 * samples;
    EXPECT_NEAR(moved_m(end - samples * 10'000'000LL, then_m), 0.0, 1e-3) << samples;
    EXPECT_NEAR(moved_m(end - samples * 10'000'000LL - 4'000'000, then_m), 0.0, 1e-3) << samples;
    EXPECT_NEAR(moved_m(end - samples * 10'000'000LL + 4'000'000, then_m), 0.0, 1e-3) << samples;
  }
  // The last 128 samples are kept.
  EXPECT_NEAR(moved_m(end - 200 * 10'000'000LL, 6.0 - 0.02 * 127), 0.0, 1e-3);
  // A correction moves the past as well: the same late fix again changes nothing more.
  InsFilter filter = flying();
  const GnssSample late{
      end - 500'000'000, {5.5, 0, 0}, Vector3::Constant(std::nan("")), Vector3::Constant(1e-3), Vector3::Ones()};
  filter.update(late);
  const double once_m = filter.state().p_m.x();
  EXPECT_NEAR(once_m, 6.5, 0.02);
  filter.update(late);
  EXPECT_NEAR(filter.state().p_m.x(), once_m, 2e-3);
}

TEST(InsHeading, NoseUpThereIsNone) {
  for (const double pitch_deg : {84.0, 84.5}) {  // the cosine is a tenth at 84.26 degrees
    InsFilter filter({}, make_pose(Vector3::Zero(), rotation_by({0, -pitch_deg * kRadPerDeg, 0})));
    filter.predict({1, Vector3::Zero(), {0, 0, kStandardGravity_mps2}});
    const InsFilter::Covariance before = filter.covariance();
    filter.update(CompassSample{1, 0.02, 0.02});
    EXPECT_EQ(filter.covariance() == before, pitch_deg > 84.26) << pitch_deg;
  }
}

// ---- the estimator around it

struct ToldIns {
  InsConfig config;
  AgentSetup setup;
  std::unique_ptr<StateEstimator> estimator;
  Outbox outbox;
  TimeNs t = 0;
  const StateEstimate& tick(const std::function<void(Observation&)>& change = {}, bool imu = true,
                            const Vector3& force = {0, 0, kStandardGravity_mps2}) {
    if (!estimator) estimator = make_ins_estimator(config, setup);
    t += 4'000'000;
    Observation observation;
    observation.t = t;
    if (imu) observation.imu.push_back({t, {0, 0, 0.3}, force});
    if (change) change(observation);
    return estimator->update(observation, outbox);
  }
};

TEST(InsLimits, WithoutTheImuItIsCarriedOnAndNotValidFromATenthOfASecondOn) {
  ToldIns ins;
  for (int i = 0; i < 50; ++i) ins.tick({}, true, {5, 0, kStandardGravity_mps2});
  const StateEstimate last = ins.tick();
  for (int i = 1; i <= 26; ++i) {
    const StateEstimate& e = ins.tick({}, false);
    EXPECT_EQ(e.valid, i <= 25) << i;
    EXPECT_LT((e.T_local_body.translation() - last.T_local_body.translation() - 0.004 * i * last.v_local_mps).norm(),
              1e-9);
    EXPECT_NEAR(yaw_of(e.T_local_body.linear()) - yaw_of(last.T_local_body.linear()), 0.3 * 0.004 * i, 1e-6);
  }
  EXPECT_STREQ(ins.estimator->fault(), "no IMU");
}

TEST(InsLimits, TooUncertainIsNotValid) {
  ToldIns ins;
  ins.config.position_sigma_max_m = 0.5;
  ins.config.start_velocity_sigma_mps = 1.0;
  ins.config.start_position_sigma_m = 0.1;
  double s = 0.0;
  while (ins.tick().valid) s = to_seconds(ins.t);
  EXPECT_STREQ(ins.estimator->fault(), "position too uncertain");
  EXPECT_NEAR(std::hypot(0.1, s), 0.5, 0.01);
}

TEST(InsLimits, UsesOnlyWhatItMay) {
  const auto uncertain_m = [](const std::function<void(InsConfig&)>& change) {
    ToldIns ins;
    ins.config.start_position_sigma_m = 2.0;
    change(ins.config);
    StateEstimate e;
    for (int i = 0; i < 5; ++i) {
      e = ins.tick([](Observation& o) {
        o.gnss.push_back({o.t, Vector3::Zero(), Vector3::Zero(), Vector3::Constant(0.1), Vector3::Constant(0.1)});
        o.altimeter.push_back({o.t, 0.0, 0.01});
        o.compass.push_back({o.t, 0.0, 0.001});
        o.odometry.push_back({o.t, Pose::Identity(), Vector3::Zero()});
      });
    }
    return Eigen::Vector2d(std::sqrt(e.covariance(0, 0)), std::sqrt(e.covariance(5, 5)));
  };
  const Eigen::Vector2d all = uncertain_m([](InsConfig&) {});
  EXPECT_LT(all.x(), 0.1);
  EXPECT_LT(all.y(), 0.001);
  EXPECT_GT(uncertain_m([](InsConfig& c) { c.use_gnss = false; }).x(), 1.9);
  EXPECT_GT(uncertain_m([](InsConfig& c) { c.use_compass = false; }).y(), 0.01);
}

}  // namespace
}  // namespace swiftlet
