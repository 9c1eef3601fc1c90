// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/tracking/motion_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <functional>
#include <numbers>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

// One decomposition for all sizes: each that the compiler must make anew takes it seconds.
using Decomposition = Eigen::LDLT<Eigen::MatrixXd>;

Eigen::MatrixXd inverse(const Eigen::MatrixXd& A) {
  return Decomposition(A).solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
}
/// Mahalanobis distance, squared.
double distance_sq(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& e) {
  return e.dot(inverse(covariance) * e);
}
bool is_positive(const Eigen::MatrixXd& covariance) { return Decomposition(covariance).vectorD().minCoeff() > 0.0; }

Vector9 state(const Vector3& p, const Vector3& v, const Vector3& a) {
  Vector9 x;
  x << p, v, a;
  return x;
}

Vector9 normal9(const Random& random, std::uint32_t tick, std::uint32_t index) {
  Vector9 x;
  for (int i = 0; i < 9; ++i) x[i] = random.normal(tick, 9 * index + i);
  return x;
}

/// Velocity and acceleration on a circle of the x-y plane, and its center's offset.
Vector9 on_circle(double radius_m, double rate_radps, double t_s) {
  const double s = std::sin(rate_radps * t_s), c = std::cos(rate_radps * t_s);
  return state(radius_m * Vector3(c, s, 0), radius_m * rate_radps * Vector3(-s, c, 0),
               -radius_m * rate_radps * rate_radps * Vector3(c, s, 0));
}

TEST(Transition, OfConstantAccelerationIsAParabola) {
  const Vector9 x = constant_acceleration_transition(0.4) * state({1, 2, 3}, {4, -5, 6}, {7, 8, -9});
  EXPECT_TRUE(x.isApprox(state({1 + 1.6 + 0.56, 2 - 2.0 + 0.64, 3 + 2.4 - 0.72}, {6.8, -1.8, 2.4}, {7, 8, -9}), 1e-12));
}

TEST(Transition, OfConstantVelocityIsALine) {
  const Vector9 x = constant_velocity_transition(0.4) * state({1, 2, 3}, {4, -5, 6}, {7, 8, -9});
  EXPECT_TRUE(x.isApprox(state({2.6, 0.0, 5.4}, {4, -5, 6}, Vector3::Zero()), 1e-12));
}

TEST(Transition, FollowsACircleInAnyPlane) {
  const Matrix3 R =
      (Eigen::AngleAxisd(0.7, Vector3::UnitX()) * Eigen::AngleAxisd(1.1, Vector3::UnitY())).toRotationMatrix();
  Matrix9 turn = Matrix9::Zero();
  for (int b = 0; b < 3; ++b) turn.block<3, 3>(3 * b, 3 * b) = R;
  for (const double rate : {0.01, 0.3, 1.7}) {
    const Vector9 before = turn * on_circle(6.0, rate, 0.3), after = turn * on_circle(6.0, rate, 0.9);
    EXPECT_NEAR(turn_rate_radps(before), rate * (6.0 * rate > 0.5), 1e-12);
    EXPECT_LT((coordinated_turn_transition(0.6, rate) * before - after).norm(), 1e-9) << rate;
  }
}

TEST(Transition, ApproachesConstantAccelerationForVanishingTurns) {
  EXPECT_LT((coordinated_turn_transition(0.1, 2e-3) - constant_acceleration_transition(0.1)).norm(), 1e-5);
  EXPECT_EQ(coordinated_turn_transition(0.1, 0.0), constant_acceleration_transition(0.1));
}

// A mode that explains no measurement keeps a small probability, so that it can recover.
TEST(ImmFilter, KeepsEveryModeRecoverable) {
  const auto filter = make_imm_filter({});
  MotionState belief = filter->start(Vector3::Zero(), 0.01 * Matrix3::Identity());
  belief.modes[0].mean[0] = belief.modes[1].mean[1] = 50.0;
  filter->correct(belief, Vector3::Zero(), 0.01 * Matrix3::Identity());
  for (const int m : {0, 1}) {
    EXPECT_GT(belief.mode_probability[static_cast<std::size_t>(m)], 0.0);
  }
  EXPECT_GT(belief.mode_probability[2], 0.99);
}

TEST(CorrectBelief, RejectsBeliefsWithIndefiniteCovariance) {
  MotionBelief belief;
  belief.covariance.topLeftCorner<3, 3>() = -2.0 * Matrix3::Identity();
  const MotionBelief before = belief;
  EXPECT_LT(correct_belief(belief, Vector3::Zero(), Matrix3::Identity()), -1e300);
  EXPECT_EQ(belief.mean, before.mean);
  EXPECT_EQ(belief.covariance, before.covariance);
}

TEST(Transition, TwoStepsAreOneLongOne) {
  EXPECT_TRUE((constant_acceleration_transition(0.3) * constant_acceleration_transition(0.2))
                  .isApprox(constant_acceleration_transition(0.5), 1e-12));
  EXPECT_TRUE((coordinated_turn_transition(0.3, 1.3) * coordinated_turn_transition(0.2, 1.3))
                  .isApprox(coordinated_turn_transition(0.5, 1.3), 1e-12));
}

TEST(ProcessNoise, GrowsWithTimeOrPerStep) {
  const ProcessNoise noise{0.01, 0.2, 0.3};
  EXPECT_TRUE((noise.covariance(0.04, 0.1) + noise.covariance(0.06, 0.1)).isApprox(noise.covariance(0.1, 0.1), 1e-12));
  EXPECT_NEAR(noise.covariance(0.1, 0.1)(4, 4), 0.04, 1e-15);
  EXPECT_EQ(noise.covariance(0.03, 0.0), noise.covariance(0.1, 0.1));
}

// After a time t without noise the position's variance is P_0 + t^2 s_v^2 + t^4 / 4 s_a^2.
TEST(KalmanFilter, SpreadsInitialUncertaintyOverTime) {
  KalmanConfig config;
  config.process.sigma_position_m = config.process.sigma_velocity_mps = config.process.sigma_acceleration_mps2 = 0.0;
  config.initial.sigma_velocity_mps = 2.0;
  config.initial.sigma_acceleration_mps2 = 3.0;
  const auto filter = make_kalman_filter(config);
  MotionState belief = filter->start(Vector3::Zero(), 0.25 * Matrix3::Identity());
  for (int i = 0; i < 8; ++i) filter->predict(belief, 0.25);
  const double t = 2.0, expected = 0.25 + t * t * 4.0 + 0.25 * std::pow(t, 4) * 9.0;
  EXPECT_LT((belief.belief.position_covariance() - expected * Matrix3::Identity()).norm(), 1e-9);
}

// A filter's last estimate is the minimum of the sum of all weighted squares: prior, every step, every measurement.
TEST(KalmanFilter, MatchesBatchLeastSquares) {
  constexpr int kSteps = 7;
  const Random random(3, "test.kalman");
  const KalmanConfig config;
  const auto filter = make_kalman_filter(config);
  const Matrix3 P0 = Vector3(0.2, 0.09, 0.5).asDiagonal();
  MotionState ours = filter->start({1, 2, 3}, P0);

  constexpr int kUnknowns = 9 * (kSteps + 1);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(kUnknowns, kUnknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(kUnknowns);
  information.topLeftCorner<9, 9>() = inverse(ours.belief.covariance);
  right.head<9>() = inverse(ours.belief.covariance) * ours.belief.mean;
  for (int k = 1; k <= kSteps; ++k) {
    const double dt_s = 0.05 + 0.2 * random.uniform(0, k);
    Matrix3 Z = 0.1 * Matrix3::Identity();
    Z(0, 1) = Z(1, 0) = 0.05 * random.uniform(1, k);
    const auto r = random.normal3(2, k);
    const Vector3 z(1.0 + r[0], 2.0 + 0.3 * k + r[1], 3.0 + r[2]);
    filter->predict(ours, dt_s);
    filter->correct(ours, z, Z);

    // x_k - A x_(k-1) ~ N(0, Xi), H x_k - z ~ N(0, Z)
    Eigen::MatrixXd D = Eigen::MatrixXd::Zero(9, kUnknowns);
    D.block<9, 9>(0, 9 * k).setIdentity();
    D.block<9, 9>(0, 9 * (k - 1)) = -constant_acceleration_transition(dt_s);
    information += D.transpose() * inverse(config.process.covariance(dt_s, config.process_period_s)) * D;
    information.block<3, 3>(9 * k, 9 * k) += inverse(Z);
    right.segment<3>(9 * k) += inverse(Z) * z;
  }
  const Eigen::MatrixXd covariance = inverse(information);
  const Eigen::VectorXd solution = covariance * right;
  EXPECT_LT((ours.belief.mean - solution.tail<9>()).norm(), 1e-6);
  EXPECT_LT((ours.belief.covariance - covariance.bottomRightCorner<9, 9>()).norm(), 1e-6);
}

TEST(KalmanFilter, IsConsistentForModelConformingTargets) {
  constexpr int kRuns = 600, kSteps = 40;
  const KalmanConfig config;
  const auto filter = make_kalman_filter(config);
  const double sigma_m = 0.3;
  const Matrix3 Z = sigma_m * sigma_m * Matrix3::Identity();
  double nees = 0.0, position_nees = 0.0;
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    const Random random(run, "test.nees");
    MotionState belief = filter->start({5, -3, 2}, Z);
    Vector9 truth =
        belief.belief.mean + belief.belief.covariance.diagonal().cwiseSqrt().cwiseProduct(normal9(random, 0, 0));
    for (std::uint32_t k = 1; k <= kSteps; ++k) {
      const double dt_s = 0.1;
      truth = constant_acceleration_transition(dt_s) * truth;
      truth += config.process.covariance(dt_s, config.process_period_s)
                   .diagonal()
                   .cwiseSqrt()
                   .cwiseProduct(normal9(random, 1, k));
      const auto r = random.normal3(2, k);
      filter->predict(belief, dt_s);
      if (k % 5 != 0) filter->correct(belief, truth.head<3>() + sigma_m * Vector3(r[0], r[1], r[2]), Z);
    }
    const Vector9 e = belief.belief.mean - truth;
    nees += distance_sq(belief.belief.covariance, e) / kRuns;
    const Vector3 p = e.head<3>();
    position_nees += distance_sq(belief.belief.position_covariance(), p) / kRuns;
  }
  // A chi-square variable of n degrees of freedom has the mean n and the variance 2 n.
  EXPECT_NEAR(nees, 9.0, 3.5 * std::sqrt(2.0 * 9.0 / kRuns));
  EXPECT_NEAR(position_nees, 3.0, 3.5 * std::sqrt(2.0 * 3.0 / kRuns));
}

TEST(KalmanFilter, MatchesGaussianDensityOfTheMeasurement) {
  MotionBelief belief;
  belief.covariance = 0.4 * Matrix9::Identity();
  belief.covariance(0, 1) = belief.covariance(1, 0) = 0.1;
  const Matrix3 Z = 0.2 * Matrix3::Identity(), S = belief.position_covariance() + Z;
  const Vector3 z(0.5, -0.3, 0.2);
  const double density =
      std::exp(-0.5 * distance_sq(S, z)) / std::sqrt(std::pow(2.0 * std::numbers::pi, 3) * S.determinant());
  EXPECT_NEAR(correct_belief(belief, z, Z), std::log(density), 1e-12);
}

TEST(KalmanFilter, CovariancesStayPositive) {
  const auto filter = make_kalman_filter({});
  MotionState belief = filter->start(Vector3::Zero(), 1e6 * Matrix3::Identity());
  for (int i = 0; i < 3000; ++i) {
    filter->predict(belief, i % 100 == 0 ? 3.0 : 1e-4);
    filter->correct(belief, Vector3::Constant(i % 7), 1e-8 * Matrix3::Identity());
    ASSERT_TRUE(belief.belief.mean.allFinite()) << i;
    ASSERT_TRUE(is_positive(belief.belief.covariance)) << i;
  }
}

TEST(ImmFilter, SwitchesModesByItsMarkovChain) {
  const auto filter = make_imm_filter({});
  MotionState belief = filter->start(Vector3::Zero(), Matrix3::Identity());
  belief.mode_probability = {0.7, 0.2, 0.1};
  // exp(Q t) by tiny steps: a mode is left at the rate 1 / sojourn, to both others alike.
  const double t_s = 0.8, sojourn_s = 2.0;
  Matrix3 Q = Matrix3::Constant(0.5 / sojourn_s);
  Q.diagonal().setConstant(-1.0 / sojourn_s);
  Matrix3 chain = Matrix3::Identity() + Q * (t_s / 1048576.0);
  for (int i = 0; i < 20; ++i) chain = chain * chain;
  const Eigen::RowVector3d expected = Eigen::RowVector3d(0.7, 0.2, 0.1) * chain;
  filter->predict(belief, t_s);
  for (int m = 0; m < 3; ++m) EXPECT_NEAR(belief.mode_probability[m], expected[m], 1e-5);
}

struct Flight {
  double rms_m = 0.0, rms_mps = 0.0, position_nees = 0.0;
  std::array<double, 3> modes{};
};

/// A target through a measured path; errors over the second half.
Flight fly(const MotionFilter& filter, const std::function<Vector9(double)>& path, double duration_s,
           std::uint32_t seed) {
  const double sigma_m = 0.1, dt_s = 0.1;
  const Matrix3 Z = sigma_m * sigma_m * Matrix3::Identity();
  const Random random(seed, "test.flight");
  MotionState belief = filter.start(path(0.0).head<3>(), Z);
  Flight flight;
  const int steps = static_cast<int>(duration_s / dt_s);
  for (int k = 1; k <= steps; ++k) {
    const Vector9 truth = path(k * dt_s);
    const auto r = random.normal3(0, k);
    filter.predict(belief, dt_s);
    filter.correct(belief, truth.head<3>() + sigma_m * Vector3(r[0], r[1], r[2]), Z);
    if (2 * k <= steps) continue;
    const Vector9 e = belief.belief.mean - truth;
    const Vector3 p = e.head<3>();
    const double n = steps - steps / 2;
    flight.rms_m += p.squaredNorm() / n;
    flight.rms_mps += e.segment<3>(3).squaredNorm() / n;
    flight.position_nees += distance_sq(belief.belief.position_covariance(), p) / n;
    for (int m = 0; m < 3; ++m) flight.modes[m] += belief.mode_probability[m] / n;
  }
  flight.rms_m = std::sqrt(flight.rms_m);
  flight.rms_mps = std::sqrt(flight.rms_mps);
  return flight;
}

TEST(ImmFilter, RecognizesStraightFlightAndTurns) {
  const auto filter = make_imm_filter({});
  const Flight straight = fly(
      *filter,
      [](double t) {
        return state(Vector3(5, 1, 0) * t, {5, 1, 0}, Vector3::Zero());
      },
      20.0, 1);
  const Flight turn = fly(
      *filter, [](double t) { return on_circle(5.0, 1.2, t); }, 20.0, 2);
  EXPECT_GT(straight.modes[0], 0.5) << straight.modes[1] << ' ' << straight.modes[2];
  EXPECT_GT(turn.modes[2], 0.5) << turn.modes[0] << ' ' << turn.modes[1];
}

// Straight lines and sharp turns by turns: what interception meets (sec. VI-B).
TEST(ImmFilter, TracksManeuversBetterThanOneModel) {
  KalmanConfig one;
  const auto kalman = make_kalman_filter(one);
  const auto imm = make_imm_filter({});
  const auto path = [](double t) {  // a stadium: 8 s straight at 5 m/s, half a circle at 1.2 rad/s, and back
    const double speed = 5.0, rate = 1.2, radius = speed / rate, straight_s = 8.0, turn_s = std::numbers::pi / rate;
    const double lap = std::fmod(t, 2.0 * (straight_s + turn_s));
    const bool back = lap >= straight_s + turn_s;
    const double s = back ? lap - straight_s - turn_s : lap;
    Vector9 x;
    if (s < straight_s)
      x = state({speed * s, 0, 0}, {speed, 0, 0}, Vector3::Zero());
    else {
      const double phase = rate * (s - straight_s);
      x = state({speed * straight_s + radius * std::sin(phase), radius * (1.0 - std::cos(phase)), 0},
                {speed * std::cos(phase), speed * std::sin(phase), 0},
                {-speed * rate * std::sin(phase), speed * rate * std::cos(phase), 0});
    }
    if (!back) return x;
    x.head<3>() = Vector3(speed * straight_s, 2.0 * radius, 0) - Vector3(x.head<3>());
    x.tail<6>() = -x.tail<6>();
    return x;
  };
  double kalman_m = 0.0, imm_m = 0.0, kalman_mps = 0.0, imm_mps = 0.0, nees = 0.0;
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    const Flight a = fly(*kalman, path, 60.0, seed), b = fly(*imm, path, 60.0, seed);
    kalman_m += a.rms_m / 10, kalman_mps += a.rms_mps / 10;
    imm_m += b.rms_m / 10, imm_mps += b.rms_mps / 10;
    nees += b.position_nees / 10;
  }
  RecordProperty("rms", std::to_string(kalman_m) + " " + std::to_string(imm_m));
  EXPECT_LT(imm_m, kalman_m);
  EXPECT_LT(imm_mps, kalman_mps) << "position " << imm_m << " against " << kalman_m;
  EXPECT_GT(nees, 2.0) << "too modest";
  EXPECT_LT(nees, 5.0) << "too sure of itself";
}

}  // namespace
}  // namespace swiftlet
