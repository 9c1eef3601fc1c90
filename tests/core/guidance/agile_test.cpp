// SPDX-License-Identifier: BSD-3-Clause
// Random smooth flight beside a plain account of its rules: a list of control points, and the spline by truncated
// powers.
#include "swiftlet/core/guidance/agile.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

using testing::GuidanceDriver;

/// Of the basis spline of degree 4 on [0, 5], by its truncated powers: sum (-1)^k binom(5, k) (t - k)_+^4 / 4!.
double basis_derivative(double t, int order) {
  constexpr double kSigned[] = {1.0, -5.0, 10.0, -10.0, 5.0, -1.0};
  double sum = 0.0;
  for (int k = 0; k <= 5; ++k) {
    if (t > k) sum += kSigned[k] * std::pow(t - k, 4 - order);
  }
  return sum / std::tgamma(5.0 - order);
}

class PlainAgile {
 public:
  PlainAgile(const AgileConfig& config, const Vector3& start_m, double rise_mps, double rise_mps2)
      : config_(config),
        random_(config.seed, "guidance.agile"),
        step_m_(config.speed_max_mps * config.knot_s),
        rise_m_(std::min(config.speed_max_mps, rise_mps) * config.knot_s),
        change_m_(config.acceleration_max_mps2 * std::pow(config.knot_s, 2)),
        change_of_rise_m_(std::min(config.acceleration_max_mps2, rise_mps2) * std::pow(config.knot_s, 2)),
        box_(config.area_min_m, config.area_max_m),
        points_m_(5, start_m) {
    box_.extend(start_m);
    draw_target();
  }

  Vector3 derivative(double t_s, int order) {
    const double knots = t_s / config_.knot_s;
    const auto first = static_cast<std::size_t>(knots);
    while (points_m_.size() < first + 5) add_point();
    Vector3 sum = Vector3::Zero();
    for (std::size_t i = 0; i < 5; ++i) {
      sum += basis_derivative(knots - static_cast<double>(first) + 4.0 - static_cast<double>(i), order) *
             points_m_[first + i];
    }
    return sum / std::pow(config_.knot_s, order);
  }
  int targets_drawn() const { return static_cast<int>(num_drawn_); }

 private:
  /// No longer than that, once its vertical part is no longer than that.
  static Vector3 shortened(Vector3 v, double length, double vertical) {
    v.z() = std::max(-vertical, std::min(vertical, v.z()));
    return v.norm() <= length ? v : Vector3(v.normalized() * length);
  }
  /// What a knot takes off a step that keeps its direction.
  double braking_m(const Vector3& step_m) const {
    return step_m.z() == 0.0 ? change_m_
                             : std::min(change_m_, change_of_rise_m_ * step_m.norm() / std::abs(step_m.z()));
  }
  bool stops_in_box(Vector3 p_m, const Vector3& step_m) const {
    if (!box_.contains(p_m)) return false;
    double left_m = step_m.norm() - braking_m(step_m);
    for (; left_m > 0.0; left_m -= braking_m(step_m)) p_m += left_m * step_m.normalized();
    return box_.contains(p_m);
  }
  /// At least a leg away, unless 32 draws find none; and how fast it goes there.
  void draw_target() {
    int left = 32;
    do {
      for (int i = 0; i < 3; ++i) {
        target_m_[i] =
            random_.uniform(config_.area_min_m[i], config_.area_max_m[i], num_drawn_, static_cast<std::uint32_t>(i));
      }
      ++num_drawn_;
    } while (--left > 0 && (target_m_ - points_m_.back()).norm() < config_.leg_min_m);
    pace_ = random_.uniform(config_.pace_min, 1.0, num_drawn_ - 1, 3);
  }
  void add_point() {
    const Vector3 p_m = points_m_.back(), step_m = p_m - points_m_[points_m_.size() - 2];
    if ((target_m_ - p_m).norm() < 4.0) draw_target();
    // Half of its speed is left at the target, and four fifths of its acceleration brake it until then.
    const Vector3 way_m = target_m_ - p_m;
    const double fastest_m = pace_ * step_m_;
    const double longest_m = std::sqrt(std::pow(0.5 * fastest_m, 2) + 2.0 * (0.8 * pace_ * change_m_) * way_m.norm());
    Vector3 wanted_m = shortened(way_m.normalized() * std::min(fastest_m, longest_m), step_m_, rise_m_);
    wanted_m = step_m + shortened(wanted_m - step_m, pace_ * change_m_, pace_ * change_of_rise_m_);
    const double slower_m = std::max(0.0, step_m.norm() - braking_m(step_m));
    const Vector3 braked_m = slower_m == 0.0 ? Vector3(Vector3::Zero()) : Vector3(step_m.normalized() * slower_m);
    double share = 1.0;
    if (!stops_in_box(p_m + wanted_m, wanted_m)) {  // to 1 part in 2^16
      share = 0.0;
      for (double half = 0.5; half >= 1.0 / 65536.0; half *= 0.5) {
        const Vector3 tried_m = braked_m + (share + half) * (wanted_m - braked_m);
        if (stops_in_box(p_m + tried_m, tried_m)) share += half;
      }
    }
    points_m_.push_back(p_m + braked_m + share * (wanted_m - braked_m));
  }

  AgileConfig config_;
  Random random_;
  double step_m_, rise_m_, change_m_, change_of_rise_m_;
  Eigen::AlignedBox3d box_;
  std::vector<Vector3> points_m_;
  Vector3 target_m_ = Vector3::Zero();
  double pace_ = 1.0;
  std::uint32_t num_drawn_ = 0;
};

void compare(const AgileConfig& config, const Vector3& start_m, double rise_mps, double rise_mps2, double duration_s) {
  AgileSpline spline(config, start_m, rise_mps, rise_mps2);
  PlainAgile plain(config, start_m, rise_mps, rise_mps2);
  const double tick_s = 0.0703125;  // a binary fraction: sums of it are exact
  for (int i = 1; i * tick_s < duration_s; ++i) {
    spline.advance(tick_s);
    const double t_s = i * tick_s;
    const Reference r = spline.reference();
    ASSERT_LT((r.position_m - plain.derivative(t_s, 0)).norm(), 1e-7) << t_s;
    ASSERT_LT((r.velocity_mps - plain.derivative(t_s, 1)).norm(), 1e-6) << t_s;
    ASSERT_LT((r.acceleration_mps2 - plain.derivative(t_s, 2)).norm(), 1e-6) << t_s;
    ASSERT_LT((spline.jerk_mps3() - plain.derivative(t_s, 3)).norm(), 1e-5) << t_s;
  }
  EXPECT_GT(plain.targets_drawn(), 3);
}

TEST(AgileSpline, FollowsItsRulesPointByPoint) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    AgileConfig config;
    config.seed = seed;
    compare(config, {0, 0, 6}, 8.5, 5.0, 120.0);
    compare(config, {-33, 5, 12}, 1.5, 0.8, 120.0);  // the box is extended to where it begins
    config.pace_min = 0.2;
    config.knot_s = 0.25;
    compare(config, {3, -4, 6}, 3.0, 2.0, 100.0);
    config.knot_s = 0.5;
    config.area_max_m.z() = 40.0;
    compare(config, {3, -4, 6}, 2.0, 1.0, 120.0);
  }
}

TEST(AgileSpline, FollowsItsRulesWhereNoTargetIsFarEnoughAway) {
  AgileConfig config;
  config.area_min_m = {-9, -9, 4};
  config.area_max_m = {9, 9, 9};
  config.leg_min_m = 40.0;
  config.pace_min = 0.6;
  compare(config, {0, 0, 6}, 8.5, 5.0, 60.0);
  config.leg_min_m = 21.0;
  compare(config, {0, 0, 6}, 8.5, 5.0, 60.0);
}

/// As slow as the usual limits of motion ask for.
AgileConfig within_usual_limits() {
  AgileConfig config;
  config.speed_max_mps = 3.5;
  config.acceleration_max_mps2 = 1.8;
  config.area_min_m = {-8, -8, 2};
  config.area_max_m = {8, 8, 8};
  config.leg_min_m = 6.0;
  config.pace_min = 0.2;
  return config;
}

TEST(Agile, HeadsAlongItsVelocityOnceItIsFastEnoughAndTellsTheRateWithinItsLimit) {
  GuidanceDriver driver("agile", within_usual_limits(), {0, 0, 5}, 0.4);
  driver.dt_s = 0.05;
  double yaw_rad = 0.4;
  int slow = 0, free = 0, cut_left = 0, cut_right = 0;
  for (int i = 0; i < 8000; ++i) {
    const Reference& r = driver.step().goal;
    const double speed_mps = r.velocity_mps.head<2>().norm(), most = MotionLimits{}.heading_rate_radps;
    double rate_radps = 0.0;
    if (speed_mps < 0.5) {
      ++slow;
    } else {
      yaw_rad = std::atan2(r.velocity_mps.y(), r.velocity_mps.x());
      rate_radps = r.velocity_mps.head<2>().dot(Eigen::Vector2d(r.acceleration_mps2.y(), -r.acceleration_mps2.x())) /
                   (speed_mps * speed_mps);
      free += std::abs(rate_radps) < most;
      cut_left += rate_radps > most;
      cut_right += rate_radps < -most;
    }
    ASSERT_NEAR(r.yaw_rad, yaw_rad, 1e-12);
    ASSERT_NEAR(r.yaw_rate_radps, std::clamp(rate_radps, -most, most), 1e-9);
  }
  for (const int seen : {slow, free, cut_left, cut_right}) EXPECT_GT(seen, 5);
  EXPECT_EQ(driver.out.mission, MissionStatus::kEndless);
}

TEST(Agile, FliesInTheWorldFromWhereItsStartLiesThere) {
  AgileConfig config = within_usual_limits();
  config.yaw = AgileConfig::Yaw::kFixed;
  config.yaw_deg = 90.0;
  const Vector3 start_m(1, -2, 4);
  GuidanceDriver driver("agile", config, start_m);
  driver.dt_s = 0.0703125;
  driver.estimate.correct(level_alignment(0.5, {2.0, 1.0, 0.5}, Vector3::Zero()));
  const Pose T_world_local = driver.estimate.T_world_local;
  const MotionLimits limits;
  PlainAgile plain(config, T_world_local * start_m, limits.vertical_speed_mps, limits.vertical_acceleration_mps2);
  for (int i = 1; i < 1000; ++i) {
    const Reference& r = driver.step().goal;
    ASSERT_LT((T_world_local * r.position_m - plain.derivative(i * driver.dt_s, 0)).norm(), 1e-7);
    ASSERT_LT((T_world_local.linear() * r.velocity_mps - plain.derivative(i * driver.dt_s, 1)).norm(), 1e-6);
    ASSERT_NEAR(r.yaw_rad, std::acos(0.0) - 0.5, 1e-12);
    ASSERT_EQ(r.yaw_rate_radps, 0.0);
  }
}

TEST(Agile, MayAskForAllThatTheLimitsAllowAndForNoMore) {
  const AgentSetup agent;
  const auto is_refused = [&](double speed_mps, double acceleration_mps2) {
    Module module(guidance_module_types(), "agile");
    module.as<AgileConfig>().speed_max_mps = speed_mps;
    module.as<AgileConfig>().acceleration_max_mps2 = acceleration_mps2;
    try {
      make_guidance(module, {agent, MotionLimits{}});
      return false;
    } catch (const std::invalid_argument&) {
      return true;
    }
  };
  EXPECT_FALSE(is_refused(4.0, 2.0));
  EXPECT_TRUE(is_refused(4.001, 2.0));
  EXPECT_TRUE(is_refused(4.0, 2.001));
}

}  // namespace
}  // namespace swiftlet
