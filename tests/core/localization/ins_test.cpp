// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/ins.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

constexpr TimeNs kImuPeriod = 5'000'000;  // 200 Hz
constexpr double kDt = 0.005;

Vector3 vec(const std::array<double, 3>& n) { return {n[0], n[1], n[2]}; }

/// A vehicle on a wavy course with an IMU, GNSS, altimeter, compass and odometry, all with exactly the noise that the
/// filter assumes.
class SimulatedFlight {
 public:
  SimulatedFlight(const InsConfig& config, std::uint64_t seed) : config_(config), random_(seed, "test.ins") {
    const auto start = [&](std::uint32_t k) { return vec(random_.normal3(0xFFFFFFFF, k)); };
    T_start_ = make_pose({3.0, -2.0, 5.0}, Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Vector3::UnitZ())));
    constexpr double kDeg = M_PI / 180.0;
    const Vector3 turn = start(2).cwiseProduct(
        Vector3(config.start_tilt_sigma_deg, config.start_tilt_sigma_deg, config.start_yaw_sigma_deg) * kDeg);
    truth_.p_m = T_start_.translation() + config.start_position_sigma_m * start(0);
    truth_.v_mps = config.start_velocity_sigma_mps * start(1);
    truth_.q = (rotation_by(turn) * Eigen::Quaterniond(T_start_.linear())).normalized();
    accel_bias_ = config.start_accel_bias_sigma_mps2 * start(3);
    gyro_bias_ = config.start_gyro_bias_sigma_radps * start(4);
  }

  const Pose& T_start() const { return T_start_; }
  const NavState& truth() const { return truth_; }
  const Vector3& accel_bias() const { return accel_bias_; }
  const Vector3& gyro_bias() const { return gyro_bias_; }
  double ground() const { return ground_; }

  ImuSample next_imu() {
    ++tick_;
    const double t = tick_ * kDt;
    // Excites all axes.
    const Vector3 omega(0.5 * std::sin(1.1 * t), 0.4 * std::cos(0.7 * t), 0.3 * std::sin(0.3 * t));
    const Vector3 a_world(1.5 * std::sin(0.6 * t), 1.2 * std::cos(0.5 * t), 0.5 * std::sin(0.9 * t));
    const Eigen::Quaterniond q_middle = truth_.q * rotation_by(0.5 * kDt * omega);
    const Vector3 force = q_middle.conjugate() * (a_world + kGravity_mps2 * Vector3::UnitZ());
    strapdown(truth_, omega, force, kDt);
    truth_.t = tick_ * kImuPeriod;

    ImuSample sample;
    sample.t = truth_.t;
    sample.omega_body_radps = omega + gyro_bias_ + config_.gyro_noise_radps_sqrt_hz / std::sqrt(kDt) * noise(0);
    sample.specific_force_body_mps2 =
        force + accel_bias_ + config_.accel_noise_mps2_sqrt_hz / std::sqrt(kDt) * noise(1);
    accel_bias_ += config_.accel_walk_mps3_sqrt_hz * std::sqrt(kDt) * noise(2);
    gyro_bias_ += config_.gyro_walk_radps2_sqrt_hz * std::sqrt(kDt) * noise(3);
    return sample;
  }
  GnssSample gnss(double sigma_p = 0.5, double sigma_v = 0.1) const {
    GnssSample s;
    s.t = truth_.t;
    s.sigma_p_m.setConstant(sigma_p);
    s.sigma_v_mps.setConstant(sigma_v);
    s.p_world_m = truth_.p_m + sigma_p * noise(4);
    s.v_world_mps = truth_.v_mps + sigma_v * noise(5);
    return s;
  }
  AltimeterSample altimeter() const { return {truth_.t, truth_.p_m.z() - ground_ + 0.03 * noise(6).x(), 0.03}; }
  CompassSample compass() const { return {truth_.t, yaw_of(truth_.q.toRotationMatrix()) + 0.03 * noise(7).x(), 0.03}; }
  OdometrySample odometry() const {
    OdometrySample s;
    s.t = truth_.t;
    const Pose T_local_world =
        make_pose({5.0, 6.0, 7.0}, Eigen::Quaterniond(Eigen::AngleAxisd(-1.3, Vector3::UnitZ())));
    s.T_local_body = T_local_world * make_pose(truth_.p_m, truth_.q);
    s.v_local_body_mps = T_local_world.linear() * (truth_.v_mps + config_.odometry_velocity_sigma_mps * noise(8));
    return s;
  }
  int tick() const { return static_cast<int>(tick_); }

 private:
  Vector3 noise(std::uint32_t channel) const { return vec(random_.normal3(tick_, channel)); }
  InsConfig config_;
  Random random_;
  Pose T_start_;
  NavState truth_;
  Vector3 accel_bias_, gyro_bias_;
  double ground_ = -0.7;
  std::uint32_t tick_ = 0;
};

using Error = Eigen::Matrix<double, 15, 1>;

Error error_of(const InsFilter& filter, const SimulatedFlight& flight) {
  Error e;
  const Eigen::AngleAxisd turn(filter.state().q.conjugate() * flight.truth().q);
  e << flight.truth().p_m - filter.state().p_m, flight.truth().v_mps - filter.state().v_mps, turn.angle() * turn.axis(),
      flight.accel_bias() - filter.accel_bias_mps2(), flight.gyro_bias() - filter.gyro_bias_radps();
  return e;
}

double nees(const InsFilter& filter, const Error& e) {
  const Eigen::Matrix<double, 15, 15> P = filter.covariance().topLeftCorner<15, 15>();
  return e.dot(P.llt().solve(e));
}

InsConfig test_config() {
  InsConfig config;
  config.ground_walk_m_sqrt_m = 0.0;  // the ground of this flight is level
  return config;
}

TEST(Ins, ErrorsMatchTheCovariance) {
  // Mean of the normalized squared error over N runs: chi-square with 15 N degrees of freedom over N. Bounds: 5 sigma,
  // sigma = sqrt(2 * 15 / N), and 10 % for what linearization leaves.
  constexpr int kRuns = 40;
  double sum_10s = 0.0, sum_30s = 0.0;
  Error squares = Error::Zero();
  for (int run = 0; run < kRuns; ++run) {
    SimulatedFlight flight(test_config(), 100 + run);
    InsFilter filter(test_config(), flight.T_start());
    for (int i = 1; i <= 6000; ++i) {
      filter.predict(flight.next_imu());
      if (i % 20 == 0) filter.update(flight.gnss());
      if (i % 4 == 0) filter.update(flight.altimeter());
      if (i % 10 == 0) filter.update(flight.compass());
      if (i % 7 == 0) filter.update(flight.odometry());
      if (i == 2000) sum_10s += nees(filter, error_of(filter, flight));
    }
    const Error e = error_of(filter, flight);
    sum_30s += nees(filter, e);
    squares += e.cwiseProduct(e);
    EXPECT_EQ(filter.num_rejected(), 0);
  }
  const double bound = 5.0 * std::sqrt(2.0 * 15.0 / kRuns);
  EXPECT_NEAR(sum_10s / kRuns, 15.0, bound + 1.5);
  EXPECT_NEAR(sum_30s / kRuns, 15.0, bound + 1.5);
  EXPECT_LT(std::sqrt(squares.head<3>().sum() / kRuns), 0.3) << "better than a GNSS of 0.87 m";
  EXPECT_LT(std::sqrt(squares.segment<3>(6).sum() / kRuns), 0.02);
}

TEST(Ins, UnaidedErrorsGrowWithTheCovariance) {
  constexpr int kRuns = 60;
  double sum = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    SimulatedFlight flight(test_config(), 500 + run);
    InsFilter filter(test_config(), flight.T_start());
    for (int i = 0; i < 600; ++i) filter.predict(flight.next_imu());
    sum += nees(filter, error_of(filter, flight));
  }
  EXPECT_NEAR(sum / kRuns, 15.0, 5.0 * std::sqrt(2.0 * 15.0 / kRuns) + 1.5);
}

TEST(Ins, UsesDelayedMeasurementsNearlyAsWell) {
  SimulatedFlight flight(test_config(), 7);
  InsFilter timely(test_config(), flight.T_start()), late(test_config(), flight.T_start());
  std::vector<GnssSample> waiting;
  double worst = 0.0;
  for (int i = 1; i <= 6000; ++i) {
    const ImuSample imu = flight.next_imu();
    timely.predict(imu);
    late.predict(imu);
    if (i % 20 == 0) {
      timely.update(flight.gnss(0.05, 0.05));
      waiting.push_back(flight.gnss(0.05, 0.05));
    }
    // Delivered 100 ms after their stamps, in which the vehicle moves by up to 0.5 m.
    if (i % 20 == 0 && waiting.size() > 1) late.update(waiting[waiting.size() - 2]);
    if (i > 3000) worst = std::max(worst, (late.state().p_m - flight.truth().p_m).norm());
  }
  EXPECT_LT(worst, 0.2);
}

TEST(Ins, RejectsOutliersAndAcceptsPersistentJumps) {
  SimulatedFlight flight(test_config(), 3);
  InsFilter filter(test_config(), flight.T_start());
  for (int i = 1; i <= 4000; ++i) {
    filter.predict(flight.next_imu());
    GnssSample sample = flight.gnss(0.1, 0.1);
    if (i % 100 == 0) sample.p_world_m.x() += 500.0;
    if (i % 20 == 0) filter.update(sample);
  }
  EXPECT_EQ(filter.num_rejected(), 40);
  EXPECT_LT((filter.state().p_m - flight.truth().p_m).norm(), 0.5);
  // From here on the receiver's world frame is shifted by 50 m to the east.
  for (int i = 1; i <= 4000; ++i) {
    filter.predict(flight.next_imu());
    GnssSample sample = flight.gnss(0.1, 0.1);
    sample.p_world_m.x() += 50.0;
    if (i % 20 == 0) filter.update(sample);
  }
  EXPECT_NEAR(filter.state().p_m.x() - flight.truth().p_m.x(), 50.0, 0.5);
  EXPECT_TRUE(filter.is_sound());
}

TEST(Ins, NotANumberChangesNothing) {
  SimulatedFlight flight(test_config(), 4);
  InsFilter filter(test_config(), flight.T_start());
  for (int i = 0; i < 100; ++i) filter.predict(flight.next_imu());
  const NavState before = filter.state();
  const double nan = std::nan("");
  ImuSample imu = flight.next_imu();
  imu.omega_body_radps.x() = nan;
  filter.predict(imu);
  GnssSample gnss = flight.gnss();
  gnss.p_world_m.x() = gnss.v_world_mps.y() = nan;
  filter.update(gnss);
  filter.update(AltimeterSample{flight.truth().t, nan, 0.1});
  filter.update(CompassSample{flight.truth().t, nan, 0.1});
  OdometrySample odometry = flight.odometry();
  odometry.v_local_body_mps.z() = nan;
  filter.update(odometry);
  EXPECT_EQ(filter.state().p_m, before.p_m);
  EXPECT_EQ(filter.state().v_mps, before.v_mps);
  EXPECT_TRUE(filter.is_sound());
}

TEST(Ins, AltimeterFindsGroundAndHoldsHeight) {
  InsConfig config = test_config();
  SimulatedFlight flight(config, 5);
  InsFilter filter(config, flight.T_start());
  for (int i = 1; i <= 4000; ++i) {
    filter.predict(flight.next_imu());
    if (i % 4 == 0) filter.update(flight.altimeter());
    if (i % 20 == 0) filter.update(flight.gnss(2.0, 0.5));
  }
  // The height above the ground is much more accurate than either height by GNSS.
  EXPECT_NEAR(filter.state().p_m.z() - filter.ground_m(), flight.truth().p_m.z() - flight.ground(), 0.05);
}

}  // namespace
}  // namespace swiftlet
