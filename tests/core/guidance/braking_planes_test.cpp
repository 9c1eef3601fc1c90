// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/separation/braking_planes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "swiftlet/core/guidance/separation_config.hpp"
#include "swiftlet/core/math/random.hpp"
#include "tests/support/draws.hpp"

namespace swiftlet {
namespace {

using testing::Draws;

constexpr double kApart_m = 1.1;

Braking drawn_braking(Draws& draws, double place_m, double path_m) {
  const Vector3 p_m = draws.vector(place_m);
  return {p_m, p_m + draws.vector(path_m)};
}

double least_between(const Braking& a, const Braking& b) {
  double least_m = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= 200; ++i) {
    const Vector3 p_m = a.p_local_m + i / 200.0 * (a.stop_local_m - a.p_local_m);
    const Vector3 leg_m = b.stop_local_m - b.p_local_m;
    const double along = std::clamp((p_m - b.p_local_m).dot(leg_m) / std::max(1e-12, leg_m.squaredNorm()), 0.0, 1.0);
    least_m = std::min(least_m, (b.p_local_m + along * leg_m - p_m).norm());
  }
  return least_m;
}

/// Distance of a point beyond the plane of `self`.
double beyond_m(const HalfSpace& cut, const Braking& self, const Vector3& q_m) {
  return cut.normal_local.dot(q_m - self.p_local_m) - cut.offset_m;
}

TEST(BrakingPlanes, PredictsBrakingDistanceFromTheLimits) {
  const MotionLimits limits;  // 2 m/s^2 level, 1 m/s^2 vertical
  const Braking level = braking_of({1.0, 2.0, 3.0}, {4.0, 0.0, 0.0}, 0.3, limits);
  EXPECT_NEAR((level.stop_local_m - Vector3(1.0 + 0.3 * 4.0 + 16.0 / 4.0, 2.0, 3.0)).norm(), 0.0, 1e-12);
  const Braking down = braking_of({0.0, 0.0, 9.0}, {0.0, 0.0, -2.0}, 0.3, limits);
  EXPECT_NEAR((down.stop_local_m - Vector3(0.0, 0.0, 9.0 - 0.6 - 2.0)).norm(), 0.0, 1e-12);
  const Braking at_rest = braking_of({5.0, 5.0, 5.0}, Vector3::Zero(), 0.3, limits);
  EXPECT_EQ(at_rest.stop_local_m, at_rest.p_local_m);
}

TEST(BrakingPlanes, KeepsDistanceAndHalfTheRoom) {
  Draws draws("rbl-separation", 7);
  int num_with_room = 0;
  for (int i = 0; i < 2000; ++i) {
    const Braking a = drawn_braking(draws, 5.0, 2.0), b = drawn_braking(draws, 5.0, 2.0);
    const HalfSpace of_a = braking_plane(a, b, kApart_m, kApart_m, 0.0);
    const HalfSpace of_b = braking_plane(b, a, kApart_m, kApart_m, 0.0);
    const double least_m = least_between(a, b);
    if (least_m < 0.01) continue;  // the braking paths cross
    ASSERT_NEAR((of_a.normal_local + of_b.normal_local).norm(), 0.0, 1e-9);
    const double kept_m = beyond_m(of_b, b, a.p_local_m + of_a.offset_m * of_a.normal_local);
    ASSERT_GE(kept_m, kApart_m - 1e-9) << i;
    if (least_m < kApart_m + 0.02) continue;
    ++num_with_room;
    ASSERT_NEAR(kept_m, kApart_m, 1e-9) << i;
    // Half the room before the braking path remains, by brute force.
    const double farthest_m = std::max(beyond_m(of_a, a, a.p_local_m), beyond_m(of_a, a, a.stop_local_m));
    ASSERT_NEAR(farthest_m, -0.5 * (least_m - kApart_m), 0.01) << i;
  }
  EXPECT_GT(num_with_room, 1000);
}

TEST(BrakingPlanes, ReservesRoomForUncertaintyWithoutRetreating) {
  const Braking self{Vector3::Zero(), {0.5, 0.0, 0.0}};
  const Braking other{{4.0, 0.0, 0.0}, {4.0, 0.0, 0.0}};
  const auto offset_m = [&](double unsure_m) {
    return braking_plane(self, other, kApart_m, kApart_m, unsure_m).offset_m;
  };
  EXPECT_NEAR(offset_m(0.0), 0.5 + 0.5 * (3.5 - kApart_m), 1e-12);
  EXPECT_NEAR(offset_m(1.0), offset_m(0.0) - 0.5, 1e-12);
  EXPECT_NEAR(offset_m(100.0), 0.5, 1e-12);  // the present braking path stays allowed
  const Braking too_near{{1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
  EXPECT_LT(braking_plane(self, too_near, kApart_m, kApart_m, 0.0).offset_m, 0.5);
}

TEST(BrakingPlanes, KeepsMoreRoomAboveAndBelow) {
  const Braking self{Vector3::Zero(), Vector3::Zero()};
  const auto offset_m = [&](const Vector3& other_m) {
    return braking_plane(self, {other_m, other_m}, 1.0, 2.0, 0.0).offset_m;
  };
  EXPECT_NEAR(offset_m({3.0, 0.0, 0.0}), 1.0, 1e-12);  // half of 3 m less 1 m
  EXPECT_NEAR(offset_m({0.0, 0.0, 4.0}), 1.0, 1e-12);  // half of 4 m less 2 m
  EXPECT_NEAR(offset_m({0.0, 0.0, 2.0}), 0.0, 1e-12);
  const HalfSpace pledged = pledge_plane(Vector3::Zero(), {0.0, 0.0, 4.0}, Vector3::Zero(), 1.0, 2.0, 0.0, 0.4);
  EXPECT_NEAR(pledged.offset_m, 0.4 * 2.0, 1e-12);
}

TEST(BrakingPlanes, HandlesCoincidentPositions) {
  const Braking self{{1.0, 1.0, 1.0}, {1.0, 1.0, 1.0}};
  const HalfSpace cut = braking_plane(self, self, 1.0, 1.5, 0.0);
  EXPECT_NEAR(cut.normal_local.norm(), 1.0, 1e-12);
  EXPECT_LT(cut.offset_m, 0.0);
}

/// Two vehicles on a line fly towards each other as fast as their pledges allow. Each sees the other at intervals and
/// with latency. Both change their speed instantly, so that only the pledge limits it. Returns the least room between
/// the vehicles.
double least_room_m(double period_s, double latency_s, double share, double noise_m, double* last_room_m = nullptr) {
  const Random random(3, "rbl-separation.pledge");
  constexpr double kTick_s = 0.01, kSpeed_mps = 4.0;
  const int period = static_cast<int>(period_s / kTick_s), late = static_cast<int>(latency_s / kTick_s);
  std::vector<double> x_m[2] = {{0.0}, {30.0}};
  double own_seen_m[2] = {0.0, 30.0}, other_seen_m[2] = {30.0, 0.0}, least_m = 30.0;
  for (int k = 1; k < 6000; ++k) {
    const int then = k - 1 - late;
    for (int i = 0; i < 2 && then >= 0 && then % period == 0; ++i) {
      own_seen_m[i] = x_m[i][static_cast<std::size_t>(then)];
      other_seen_m[i] =
          x_m[1 - i][static_cast<std::size_t>(then)] +
          noise_m * random.uniform(-1.0, 1.0, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(k));
    }
    for (int i = 0; i < 2; ++i) {
      const double now_m = x_m[i].back();
      const HalfSpace cut =
          pledge_plane({own_seen_m[i], 0, 0}, {other_seen_m[i], 0, 0}, {now_m, 0, 0}, kApart_m, 1.5, noise_m, share);
      const double ahead_m = std::clamp(cut.offset_m, 0.0, kSpeed_mps * kTick_s);
      x_m[i].push_back(now_m + cut.normal_local.x() * ahead_m);
    }
    least_m = std::min(least_m, x_m[1].back() - x_m[0].back() - kApart_m);
  }
  if (last_room_m != nullptr) *last_room_m = x_m[1].back() - x_m[0].back() - kApart_m;
  return least_m;
}

TEST(BrakingPlanes, KeepsPledgedDistanceDespiteRareObservations) {
  for (const double period_s : {0.1, 0.5, 2.0}) {
    for (const double latency_s : {0.0, 0.05, 0.4}) {
      for (const double noise_m : {0.0, 0.5}) {
        double last_m = 0.0;
        EXPECT_GE(least_room_m(period_s, latency_s, 0.45, noise_m, &last_m), -1e-9) << period_s << ' ' << latency_s;
        EXPECT_LT(last_m, 0.1 + 3.0 * noise_m) << "they come together, though";
      }
    }
  }
  EXPECT_LT(least_room_m(2.0, 0.4, 0.9, 0.0), 0.0) << "with more than half they meet";
}

TEST(BrakingPlanes, DodgesToExactlyTheSafetyDistance) {
  const MotionLimits limits;
  Draws draws("rbl-separation", 7);
  int num_dodged = 0, num_level = 0;
  for (int i = 0; i < 20000; ++i) {
    const double vertical_m = i % 2 == 0 ? kApart_m : 1.5;
    const Braking self = drawn_braking(draws, 2.0, 1.0);
    const Vector3 other_m = draws.vector(6.0), v_mps = draws.vector(4.0);
    const auto cut = evasion_plane(self, other_m, v_mps, kApart_m, vertical_m, limits);
    const Vector3 scale(1.0, 1.0, kApart_m / vertical_m);
    const Vector3 ahead = scale.cwiseProduct(v_mps).normalized();
    const auto beside_m = [&](const Vector3& q_m) {
      const Vector3 r_m = scale.cwiseProduct(q_m - other_m);
      return (r_m - r_m.dot(ahead) * ahead).norm();
    };
    const bool comes = scale.cwiseProduct(self.stop_local_m - other_m).dot(ahead) > 0.0;
    ASSERT_EQ(cut.has_value(), comes && beside_m(self.stop_local_m) < kApart_m) << i;
    if (!cut) continue;
    ++num_dodged;
    num_level += cut->normal_local.z() == 0.0;
    ASSERT_NEAR(cut->normal_local.norm(), 1.0, 1e-12);
    // The displacement from the stopping point to the plane is perpendicular to the plane in the scaled space.
    const Vector3 out = -scale.cwiseInverse().cwiseProduct(scale.cwiseInverse().cwiseProduct(cut->normal_local));
    const double lacking_m = cut->normal_local.dot(self.stop_local_m - self.p_local_m) - cut->offset_m;
    ASSERT_GT(lacking_m, 0.0);
    const Vector3 q_m = self.stop_local_m + lacking_m / -out.dot(cut->normal_local) * out;
    ASSERT_NEAR(beside_m(q_m), kApart_m, 1e-6) << i;
  }
  EXPECT_GT(num_dodged, 100);
  EXPECT_GT(num_level, 50);
}

/// Direction in which a vehicle evades an intruder that flies east at 3 m/s, 5 m west of it.
Vector3 evasion(const Vector3& p_m, const MotionLimits& limits = {}) {
  const auto cut = evasion_plane({p_m, p_m}, {-5.0, 0.0, 0.0}, {3.0, 0.0, 0.0}, kApart_m, 1.5, limits);
  return cut ? Vector3(-cut->normal_local) : Vector3(Vector3::Zero());
}

TEST(BrakingPlanes, DodgesRightOnCollisionCourse) {
  EXPECT_NEAR(evasion(Vector3::Zero()).y(), -1.0, 1e-12);  // the intruder's right is the south
  EXPECT_NEAR(evasion({0.0, 0.2, 0.0}).y(), 1.0, 1e-12);
  EXPECT_NEAR(evasion({0.0, -0.2, 0.0}).y(), -1.0, 1e-12);
}

TEST(BrakingPlanes, DodgesLevelUnlessVerticallyFaster) {
  MotionLimits climbing;
  climbing.vertical_acceleration_mps2 = 20.0;
  EXPECT_EQ(evasion({0.0, 0.05, 0.3}).z(), 0.0);
  EXPECT_GT(evasion({0.0, 0.05, 0.3}, climbing).z(), 0.5);
  EXPECT_GT(evasion({0.0, 0.05, 1.4}).z(), 0.5) << "almost high enough";
  EXPECT_LT(evasion({0.0, 0.05, -1.4}).z(), -0.5);
  const Vector3 p_m = Vector3::Zero();
  const auto falling = evasion_plane({p_m, p_m}, {0.0, 0.0, 4.0}, {0.0, 0.0, -2.0}, kApart_m, 1.5, MotionLimits{});
  ASSERT_TRUE(falling.has_value());
  EXPECT_EQ(falling->normal_local.z(), 0.0);
}

TEST(BrakingPlanes, CapsLimitsKeepingVerticalProportions) {
  MotionLimits limits;
  limits.horizontal_acceleration_mps2 = 6.0;
  limits.vertical_acceleration_mps2 = 3.0;
  limits.horizontal_jerk_mps3 = 80.0;
  limits.vertical_jerk_mps3 = 40.0;
  SeparationConfig separation;
  separation.acceleration_mps2 = 2.0;
  separation.jerk_mps3 = 20.0;
  const MotionLimits cut = separation.within(limits);
  EXPECT_EQ(cut.horizontal_acceleration_mps2, 2.0);
  EXPECT_EQ(cut.vertical_acceleration_mps2, 1.0);
  EXPECT_EQ(cut.horizontal_jerk_mps3, 20.0);
  EXPECT_EQ(cut.vertical_jerk_mps3, 10.0);
  EXPECT_EQ(cut.horizontal_speed_mps, limits.horizontal_speed_mps);
  const MotionLimits slow{1.0, 1.0, 10.0, 1.0, 1.0, 10.0, 0.5, 1.0};
  EXPECT_EQ(separation.within(slow).horizontal_acceleration_mps2, 1.0);
  EXPECT_EQ(separation.within(slow).vertical_jerk_mps3, 10.0);
}

TEST(BrakingPlanes, LimitsSpeedInUnknownByBraking) {
  const double v_mps = speed_into_unknown_mps(15.0, 2.7, kApart_m, 2.0);
  const double way_m = v_mps * 2.7 + v_mps * v_mps / (2.0 * 2.0);
  EXPECT_NEAR(2.0 * way_m + kApart_m, 15.0, 1e-9);
  EXPECT_GT(speed_into_unknown_mps(15.0, 0.45, kApart_m, 2.0), 4.0);
  EXPECT_EQ(speed_into_unknown_mps(1.0, 0.45, kApart_m, 2.0), 0.0);
  EXPECT_GT(speed_into_unknown_mps(std::numeric_limits<double>::infinity(), 2.7, kApart_m, 2.0), 1e9);
}

}  // namespace
}  // namespace swiftlet
