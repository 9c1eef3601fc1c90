// SPDX-License-Identifier: BSD-3-Clause
// What the rule-based Lloyd algorithm is built from, beside its rules written out plainly: where a vehicle looks, what
// voxels cut off, how it brakes behind planes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "core/guidance/rbl_sight.hpp"
#include "swiftlet/core/guidance/guarded_reference.hpp"
#include "swiftlet/core/guidance/rbl_obstacles.hpp"
#include "swiftlet/core/guidance/rbl_planner.hpp"
#include "swiftlet/core/guidance/rbl_separation.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

class PartDraws {
 public:
  PartDraws(std::uint64_t seed, std::uint32_t round) : random_(seed, "test.rbl-parts"), round_(round) {}
  double between(double min, double max) { return random_.uniform(min, max, round_, index_++); }
  int below(int end) { return static_cast<int>(end * between(0.0, 1.0)); }
  Vector3 vector(double half) {
    const double x = between(-half, half), y = between(-half, half);
    return {x, y, between(-half, half)};
  }

 private:
  Random random_;
  std::uint32_t round_, index_ = 0;
};

Matrix3 about_z(double angle_rad) { return Eigen::AngleAxisd(angle_rad, Vector3::UnitZ()).toRotationMatrix(); }

// ---- sight

struct PlainSight {
  std::vector<NeighborView> views;
  std::array<TimeNs, 24> looked{};
  int glance = -1;

  bool sees(const Vector3& p_body_m) const {
    bool any = false;
    for (const NeighborView& view : views) any = any || view.contains(p_body_m);
    return any;
  }
  static Vector3 azimuth(int i) { return {std::cos(i * kPi / 12.0), std::sin(i * kPi / 12.0), 0.0}; }
  bool flies_blindly(double heading_rad, const Vector3& ahead_m) const {
    return ahead_m.norm() > 0.3 && !sees_nearly(about_z(-heading_rad) * ahead_m.normalized());
  }
  /// A fifth beside the view where the direction is level, nothing where it is upright.
  bool sees_nearly(const Vector3& ahead_body) const {
    return sees(ahead_body + Vector3(0.2 * ahead_body.head<2>().norm(), 0.0, 0.0));
  }
  bool shows(double heading_rad, int k, const Vector3& ahead_m) const {
    return sees(about_z(-heading_rad) * azimuth(k)) && !flies_blindly(heading_rad, ahead_m);
  }

  /// The azimuth that it has not seen for longest, of those that it can see: until it has seen that one.
  void choose(double yaw_rad, const Vector3& ahead_m, TimeNs now) {
    std::array<bool, 24> can{};
    for (int i = 0; i < 24; ++i) {
      for (int k = 0; k < 24; ++k) {
        if (shows(yaw_rad + std::remainder(i * kPi / 12.0, 2.0 * kPi), k, ahead_m))
          can[static_cast<std::size_t>(k)] = true;
      }
    }
    const auto at = [](int k) { return static_cast<std::size_t>(k); };
    if (glance >= 0 && looked[at(glance)] < now && can[at(glance)]) return;
    glance = -1;
    for (int k = 23; k >= 0; --k) {
      if (can[at(k)] && looked[at(k)] < now && (glance < 0 || looked[at(k)] <= looked[at(glance)])) glance = k;
    }
  }

  /// What one heading costs: who is unseen, longest and soonest here first, who comes, the way ahead, the glance; and a
  /// little for the turn.
  double cost(double turn_rad, double yaw_rad, const Vector3& ahead_m, const Vector3& p_m,
              const std::vector<Neighbor>& neighbors, const std::vector<Vector3>& coming_m, TimeNs now) const {
    const Matrix3 to_body = about_z(-yaw_rad - turn_rad);
    double sum = 0.01 * std::abs(turn_rad);
    for (const Neighbor& other : neighbors) {
      const Vector3 to_m = other.position_local_m - p_m;
      const double comes_mps = std::max(0.0, -to_m.normalized().dot(other.velocity_local_mps));
      if (!sees(to_body * to_m))
        sum += (1.0 + to_seconds(now - other.seen)) / std::max(to_m.norm() / (1.0 + comes_mps), 1.0);
    }
    for (const Vector3& q_m : coming_m) sum += sees(to_body * (q_m - p_m)) ? 0.0 : 5.0;
    if (ahead_m.norm() > 0.3 && !sees(to_body * ahead_m)) sum += 2.0;
    if (glance < 0 || shows(yaw_rad + turn_rad, glance, ahead_m)) return sum;
    const double unlooked_s = to_seconds(now - looked[static_cast<std::size_t>(glance)]);
    return sum + std::clamp(2.0 * (unlooked_s - 1.0), 0.0, 4.0);
  }
};

TEST(RblSightReference, TheHeadingIsTheCheapestOfTwentyFour) {
  int turns = 0, stands = 0, glances = 0;
  for (std::uint32_t round = 0; round < 40; ++round) {
    PartDraws draws(1, round);
    NeighborView view;
    view.cones.push_back({Vector3(1.0, draws.between(-0.5, 0.5), draws.between(-0.2, 0.2)).normalized(),
                          std::cos(draws.between(0.3, 1.6))});
    PlainSight plain;
    plain.views = {view};
    if (draws.below(2) == 0) {
      view.cones[0].axis_body = Vector3(-1.0, draws.between(-1.0, 1.0), 0.0).normalized();
      plain.views.push_back(view);
    }
    RblSight sight(plain.views);
    TimeNs now = 0;
    double yaw_rad = draws.between(-3.0, 3.0);
    for (int update = 0; update < 12; ++update) {
      now += from_seconds(draws.between(0.1, 3.0));
      Pose T = make_pose(draws.vector(5.0), Eigen::Quaterniond::Identity());
      T.linear() = about_z(yaw_rad + draws.between(-0.3, 0.3)) *
                   Eigen::AngleAxisd(draws.between(-0.2, 0.2), Vector3::UnitY()).toRotationMatrix();
      const bool flies = draws.below(2) == 0;
      const Vector3 ahead_m =
          draws.vector(1.0).normalized() * (flies ? draws.between(0.31, 3.0) : draws.between(0.0, 0.29));
      std::vector<Neighbor> neighbors(static_cast<std::size_t>(draws.below(4)));
      for (Neighbor& other : neighbors) {
        other.position_local_m = T.translation() + draws.vector(draws.below(2) == 0 ? 1.2 : 6.0);
        other.seen = now - from_seconds(draws.between(0.0, 4.0));
        other.velocity_local_mps = draws.vector(3.0);
      }
      std::vector<Vector3> coming_m(static_cast<std::size_t>(draws.below(3)));
      for (Vector3& q_m : coming_m) q_m = T.translation() + draws.vector(6.0);
      for (int k = 0; k < 24; ++k) {
        if (plain.sees(T.linear().transpose() * PlainSight::azimuth(k)))
          plain.looked[static_cast<std::size_t>(k)] = now;
      }
      plain.choose(yaw_rad, ahead_m, now);
      const double got_rad = sight.heading(T, T.translation() + ahead_m, neighbors, coming_m, yaw_rad, now);
      double least = std::numeric_limits<double>::infinity(), nearest_rad = 10.0, its_turn_rad = 0.0;
      for (int i = 0; i < 24; ++i) {
        const double turn_rad = std::remainder(i * kPi / 12.0, 2.0 * kPi);
        least = std::min(least, plain.cost(turn_rad, yaw_rad, ahead_m, T.translation(), neighbors, coming_m, now));
        const double off_rad = std::abs(std::remainder(got_rad - yaw_rad - turn_rad, 2.0 * kPi));
        if (off_rad >= nearest_rad) continue;
        nearest_rad = off_rad;
        its_turn_rad = turn_rad;
      }
      ASSERT_LT(nearest_rad, 1e-9) << "a multiple of 15 degrees away";
      ASSERT_NEAR(plain.cost(its_turn_rad, yaw_rad, ahead_m, T.translation(), neighbors, coming_m, now), least, 1e-9)
          << round << ", " << update;
      ASSERT_LE(std::abs(got_rad), kPi + 1e-12);
      const Vector3 body_m = T.linear().transpose() * ahead_m;
      ASSERT_EQ(sight.sees_ahead(T, T.translation() + ahead_m),
                body_m.norm() < 0.3 || plain.sees_nearly(body_m.normalized()));
      turns += its_turn_rad != 0.0;
      glances += plain.glance >= 0;
      stands += !flies;
      yaw_rad = got_rad;
    }
  }
  EXPECT_GT(turns, 100);
  EXPECT_GT(stands, 100);
  EXPECT_GT(glances, 200);
}

TEST(RblSightReference, WhoSeesAllAroundNeverTurns) {
  RblSight sight({});
  Neighbor behind;
  behind.position_local_m = {-5, 0, 0};
  EXPECT_EQ(sight.heading(Pose::Identity(), {-3, 0, 0}, std::vector<Neighbor>{behind}, {}, 0.7, 5 * kNsPerSecond), 0.7);
  EXPECT_TRUE(sight.sees_ahead(Pose::Identity(), {-3, 0, 0}));
}

// ---- voxels

constexpr double kVoxel_m = 0.2;

/// Centers of voxels around a place, in no order.
std::vector<Vector3> drawn_voxels_m(PartDraws& draws, const Vector3& p_m, int count, double reach_m) {
  std::vector<Vector3> voxels_m;
  for (int i = 0; i < count; ++i) {
    const Vector3 q_m = p_m + draws.vector(reach_m);
    voxels_m.emplace_back(((q_m.array() / kVoxel_m).floor() + 0.5).matrix() * kVoxel_m);
  }
  return voxels_m;
}

/// The agent keeps its encumbrance to the nearest point, or flies away from the middle of a voxel that it is in.
HalfSpace plain_voxel_cut(const Vector3& nearest_m, const Vector3& center_m, double encumbrance_m, double eta) {
  if (nearest_m.norm() > 0.01) return obstacle_cut(nearest_m, encumbrance_m, eta);
  return {center_m.norm() > 0.01 ? Vector3(center_m.normalized()) : Vector3(0, 0, 1), -encumbrance_m};
}

TEST(ObstacleCutterReference, ConvexCutsAreAtTheNearestVoxelThatIsNotYetBehindOne) {
  int inside = 0;
  std::size_t most = 0;
  for (std::uint32_t round = 0; round < 80; ++round) {
    PartDraws draws(2, round);
    const Vector3 p_m = draws.vector(4.0);
    const double encumbrance_m = draws.between(0.3, 0.7), eta = draws.between(0.6, 0.95);
    std::vector<Vector3> voxels_m = drawn_voxels_m(draws, p_m, draws.below(60), 3.0);
    if (round % 4 == 0)
      voxels_m.push_back(((p_m.array() / kVoxel_m).floor() + 0.5).matrix() * kVoxel_m);  // it is inside
    RblCell cell(2.5, 0.3, false), plain(2.5, 0.3, false);
    ObstacleCutter cutter;
    std::vector<HalfSpace> cuts;
    cutter.cut_convex(cell, p_m, voxels_m, kVoxel_m, encumbrance_m, eta, cuts);

    std::vector<bool> left(voxels_m.size(), true);
    const auto nearest_m = [&](std::size_t i) {
      return nearest_in_voxel(Vector3::Zero(), voxels_m[i] - p_m, kVoxel_m);
    };
    for (const HalfSpace& cut : cuts) {
      std::size_t first = voxels_m.size();
      for (std::size_t i = 0; i < voxels_m.size(); ++i) {
        if (left[i] && (first == voxels_m.size() || nearest_m(i).norm() < nearest_m(first).norm() - 1e-7)) first = i;
      }
      ASSERT_LT(first, voxels_m.size()) << "there is nothing left to keep clear of";
      const HalfSpace expected = plain_voxel_cut(nearest_m(first), voxels_m[first] - p_m, encumbrance_m, eta);
      ASSERT_LT((cut.normal_local - expected.normal_local).norm(), 1e-5) << round;
      ASSERT_NEAR(cut.offset_m, expected.offset_m, 1e-5) << round;
      inside += nearest_m(first).norm() <= 0.01;
      const double reach_m = nearest_m(first).norm() - 1e-4;
      left[first] = false;
      for (std::size_t i = 0; i < voxels_m.size(); ++i)
        left[i] = left[i] && expected.normal_local.dot(nearest_m(i)) < reach_m;
      plain.cut(cut);
    }
    EXPECT_EQ(std::count(left.begin(), left.end(), true), 0);
    for (int i = 0; i < cell.num_samples(); ++i) ASSERT_EQ(cell.contains(i), plain.contains(i));
    most = std::max(most, cuts.size());
  }
  EXPECT_GT(inside, 10);
  EXPECT_GT(most, 8U);
}

TEST(ObstacleCutterReference, EachSampleIsJudgedByTheVoxelNearestToItsOwn) {
  int compared = 0, taken_out = 0;
  for (std::uint32_t round = 0; round < 40; ++round) {
    PartDraws draws(3, round);
    const Vector3 p_m = draws.vector(4.0);
    const double encumbrance_m = draws.between(0.2, 0.7), eta = draws.between(0.6, 0.95);
    const double radius_m = draws.between(1.0, 2.0);
    const std::vector<Vector3> voxels_m = drawn_voxels_m(draws, p_m, 1 + draws.below(30), 2.5);
    RblCell cell(radius_m, radius_m / 7.0, round % 3 == 0);
    cell.cut({draws.vector(1.0).normalized(), 0.5 * radius_m});
    RblCell before = cell;
    ObstacleCutter cutter;
    cutter.cut_nearest(cell, p_m, voxels_m, kVoxel_m, encumbrance_m, eta);

    const auto cell_of = [](const Vector3& q_m) { return Cell((q_m.array() / kVoxel_m).floor().cast<int>()); };
    const int half = static_cast<int>(std::ceil(radius_m / eta / kVoxel_m)) + 1;
    for (int i = 0; i < cell.num_samples(); ++i) {
      if (!before.contains(i)) {
        ASSERT_FALSE(cell.contains(i));
        continue;
      }
      const Vector3 q = cell.point(i);
      int least = std::numeric_limits<int>::max();
      bool any_out = false, any_in = false, unsure = false;
      for (const bool judge : {false, true}) {
        for (const Vector3& voxel_m : voxels_m) {
          if ((cell_of(voxel_m) - cell_of(p_m)).cwiseAbs().maxCoeff() > half) continue;  // too far to matter
          const int distance = (cell_of(voxel_m) - cell_of(p_m + q)).squaredNorm();
          if (!judge) least = std::min(least, distance);
          if (!judge || distance > least) continue;
          const Vector3 center_m = voxel_m - p_m, nearest_m = nearest_in_voxel(q, center_m, kVoxel_m);
          const HalfSpace cut = plain_voxel_cut(nearest_m, center_m, encumbrance_m, eta);
          const double beyond_m = cut.normal_local.dot(q) - cut.offset_m;
          unsure = unsure || std::abs(beyond_m) < 1e-4 || std::abs(nearest_m.norm() - 0.01) < 1e-4;
          (beyond_m > 0.0 ? any_out : any_in) = true;
        }
      }
      const Vector3 in_cell = (p_m + q) / kVoxel_m;  // single precision may put it into the cell beside
      unsure = unsure || (in_cell - in_cell.array().round().matrix()).cwiseAbs().minCoeff() < 1e-4;
      if (unsure || any_out == any_in) continue;
      ASSERT_EQ(cell.contains(i), any_in) << round << ": " << q.transpose();
      ++compared;
      taken_out += any_out;
    }
  }
  EXPECT_GT(compared, 8000);
  EXPECT_GT(taken_out, 1000);
}

TEST(ObstacleCutterReference, WithoutVoxelsOrWithoutACellNothingIsCut) {
  ObstacleCutter cutter;
  RblCell cell(2.0, 0.3, false);
  const int all = cell.num_partitioned();
  cutter.cut_nearest(cell, {0, 0, 0}, {}, kVoxel_m, 0.5, 0.9);
  EXPECT_EQ(cell.num_partitioned(), all);
  const std::vector<Vector3> far_m = {{50.1, 0.1, 0.1}};
  cutter.cut_nearest(cell, {0, 0, 0}, far_m, kVoxel_m, 0.5, 0.9);
  EXPECT_EQ(cell.num_partitioned(), all);
  cell.cut({Vector3::UnitX(), -3.0});
  cutter.cut_nearest(cell, {0, 0, 0}, std::vector<Vector3>{{0.7, 0.1, 0.1}}, kVoxel_m, 0.5, 0.9);
  EXPECT_TRUE(cell.is_empty());
  // Right in the middle of a voxel it goes up or down, away from its middle by the encumbrance.
  std::vector<HalfSpace> cuts;
  cutter.cut_convex(cell, {0.1, 0.1, 0.1}, std::vector<Vector3>{{0.1, 0.1, 0.105}}, kVoxel_m, 0.5, 0.9, cuts);
  ASSERT_EQ(cuts.size(), 1U);
  EXPECT_EQ(cuts[0].normal_local, Vector3(0, 0, 1));
  EXPECT_EQ(cuts[0].offset_m, -0.5);
}

// ---- braking ways

/// Least distance of two segments, by trying many pairs of points.
std::pair<Vector3, Vector3> nearest_by_trying(const Vector3& a, const Vector3& a_end, const Vector3& b,
                                              const Vector3& b_end) {
  std::pair<Vector3, Vector3> best{a, b};
  for (int i = 0; i <= 1000; ++i) {
    const Vector3 p = a + i / 1000.0 * (a_end - a), way = b_end - b;
    const double length_sq = way.squaredNorm();
    const double along = length_sq > 0.0 ? std::clamp((p - b).dot(way) / length_sq, 0.0, 1.0) : 0.0;
    const Vector3 q = b + along * way;
    if ((q - p).norm() < (best.second - best.first).norm()) best = {p, q};
  }
  return best;
}

TEST(RblSeparationReference, PlanesLieHalfwayBetweenTheNearestPointsOfTheWays) {
  int compared = 0;
  for (std::uint32_t round = 0; round < 1500; ++round) {
    PartDraws draws(4, round);
    const double distance_m = draws.between(0.5, 1.5), vertical_m = draws.between(0.5, 2.5);
    const double unsure_m = draws.below(2) == 0 ? 0.0 : draws.between(0.0, 2.0);
    Braking self{draws.vector(4.0), {}}, other{draws.vector(4.0), {}};
    const int kind = draws.below(6);
    const Vector3 way_m = draws.vector(2.0);
    self.stop_local_m = self.p_local_m + (kind == 1 || kind == 3 ? Vector3(Vector3::Zero()) : way_m);
    other.stop_local_m = other.p_local_m + (kind == 2 || kind == 3 ? Vector3(Vector3::Zero())
                                            : kind == 4            ? Vector3(draws.between(-2.0, 2.0) * way_m)
                                                                   : draws.vector(2.0));
    const Vector3 scale(1.0, 1.0, distance_m / vertical_m);
    const auto scaled = [&](const Vector3& v) { return Vector3(scale.cwiseProduct(v)); };
    const auto [mine, theirs] = nearest_by_trying(scaled(self.p_local_m), scaled(self.stop_local_m),
                                                  scaled(other.p_local_m), scaled(other.stop_local_m));
    const double d = (theirs - mine).norm();
    if (d < 0.05) continue;
    const HalfSpace cut = braking_cut(self, other, distance_m, vertical_m, unsure_m);
    ASSERT_NEAR(cut.normal_local.norm(), 1.0, 1e-12);
    // In the space where heights count less or more: n . S q <= offset.
    const Vector3 normal = (theirs - mine) / d;
    const double room_m = d - distance_m;
    double share_m = room_m;  // who is too near makes all of the room
    if (room_m > 0.0) share_m = std::max(0.0, 0.5 * room_m - 0.5 * unsure_m);
    const double stretch = scaled(normal).norm();
    const double offset_m = (normal.dot(mine - scaled(self.p_local_m)) + share_m) / stretch;
    const double slack = kind == 4 ? 0.02 : 0.01;  // of ways side by side any pair will do
    ASSERT_LT((cut.normal_local - scaled(normal) / stretch).norm(), slack / d) << round;
    ASSERT_NEAR(cut.offset_m, offset_m, 5.0 * slack) << round << ", kind " << kind;
    ++compared;
  }
  EXPECT_GT(compared, 1000);
}

TEST(RblSeparationReference, SlantedWaysAreAsLongAsTheScarcerAccelerationAsks) {
  for (std::uint32_t round = 0; round < 200; ++round) {
    PartDraws draws(5, round);
    MotionLimits limits;
    limits.horizontal_acceleration_mps2 = draws.between(0.5, 5.0);
    limits.vertical_acceleration_mps2 = draws.between(0.5, 5.0);
    const Vector3 p_m = draws.vector(3.0), v_mps = draws.vector(5.0);
    const double reaction_s = draws.between(0.0, 1.0);
    // Braking along the velocity: each part within its limit.
    const double braking_s = std::max(v_mps.head<2>().norm() / limits.horizontal_acceleration_mps2,
                                      std::abs(v_mps.z()) / limits.vertical_acceleration_mps2);
    const Braking way = braking_of(p_m, v_mps, reaction_s, limits);
    EXPECT_EQ(way.p_local_m, p_m);
    EXPECT_LT((way.stop_local_m - p_m - (reaction_s + 0.5 * braking_s) * v_mps).norm(), 1e-9);
  }
}

TEST(RblSeparationReference, WaysThatCrossPartAlongWhereTheOtherIsNow) {
  const Braking self{{0, 0, 0}, {4, 0, 0}}, other{{2, -1, 0}, {2, 3, 0}};
  const HalfSpace cut = braking_cut(self, other, 1.0, 1.0, 0.0);
  EXPECT_LT((cut.normal_local - Vector3(2, -1, 0).normalized()).norm(), 1e-9);
  EXPECT_NEAR(cut.offset_m, Vector3(2, -1, 0).normalized().x() * 2.0 - 1.0, 1e-9);
}

// ---- a reference behind planes

ReferenceGovernor braked(ReferenceGovernor governor, double yaw_rad, double tick_s) {
  governor.accelerate(-5.0 * governor.state().velocity_mps, yaw_rad, tick_s);
  return governor;
}

/// Brakes tick by tick until it stands, for 20 s at most.
Vector3 plain_rest_m(ReferenceGovernor governor) {
  for (double t_s = 0.0; t_s < 20.0 - 1e-9 && governor.state().velocity_mps.norm() > 0.02; t_s += 0.05)
    governor = braked(governor, governor.state().yaw_rad, 0.05);
  return governor.state().position_m;
}

TEST(GuardedReferenceRules, TheGoalIsTheFarthestOfFourThatLeavesRoomToStop) {
  std::map<double, int> chosen;
  int behind = 0;
  for (std::uint32_t round = 0; round < 120; ++round) {
    PartDraws draws(6, round);
    MotionLimits limits;
    limits.horizontal_jerk_mps3 = draws.between(5.0, 40.0);
    limits.horizontal_acceleration_mps2 = draws.between(0.8, 3.0);
    GuardedReference guarded(limits);
    ReferenceGovernor plain(limits);
    Reference start;
    start.velocity_mps = draws.vector(2.0);
    start.yaw_rad = draws.between(-3.0, 3.0);
    guarded.reset(start);
    plain.reset(start);
    Vector3 last_m = draws.vector(1.0);
    const double period_s = draws.between(0.1, 0.4), speed_mps = draws.between(1.0, 4.0);
    for (int update = 0; update < 6; ++update) {
      const Vector3 p_m = plain.state().position_m + draws.vector(0.02), goal_m = p_m + draws.vector(5.0);
      std::vector<HalfSpace> planes(static_cast<std::size_t>(draws.below(4)));
      for (HalfSpace& plane : planes) plane = {draws.vector(1.0).normalized(), draws.between(-0.1, 2.5)};
      const Vector3 rest_m = plain_rest_m(plain);
      ASSERT_LT((guarded.rest_local_m() - rest_m).norm(), 1e-9);

      const auto is_kept = [&](const Vector3& stop_m) {
        return std::all_of(planes.begin(), planes.end(), [&](const HalfSpace& plane) {
          const double allowed_m = std::max({plane.offset_m, 0.0, plane.normal_local.dot(rest_m - p_m)});
          return plane.normal_local.dot(stop_m - p_m) <= allowed_m + 1e-3;
        });
      };
      double share = -1.0;
      for (const double tried : {0.0, 0.25, 0.5, 1.0}) {
        const Vector3 to_m = rest_m + tried * (goal_m - rest_m);
        ReferenceGovernor ahead = plain;
        for (int part = 1; part <= 4; ++part) {
          Reference glides;
          glides.yaw_rad = plain.state().yaw_rad;
          glides.position_m = last_m + 0.25 * part * (to_m - last_m);
          ahead.step(glides, 0.25 * period_s, speed_mps);
        }
        if (is_kept(plain_rest_m(ahead))) share = tried;
      }
      if (planes.empty()) share = 1.0;
      ++chosen[share];
      const Vector3 admitted_m = guarded.admit(last_m, goal_m, planes, p_m, period_s, speed_mps);
      const Vector3 expected_m = share < 0.0 ? rest_m : Vector3(rest_m + share * (goal_m - rest_m));
      ASSERT_LT((admitted_m - expected_m).norm(), 1e-9) << round << ", " << update << ": " << share;

      for (int tick = 0; tick < 5; ++tick) {
        Reference goal;
        goal.position_m = last_m + 0.2 * (tick + 1) * (admitted_m - last_m);
        goal.yaw_rad = 0.3;
        const Reference& got = guarded.step(goal, 0.2 * period_s, speed_mps);
        if (share < 0.0) {
          plain = braked(plain, 0.3, 0.2 * period_s);
          ++behind;
        } else {
          plain.step(goal, 0.2 * period_s, speed_mps);
        }
        ASSERT_LT((got.position_m - plain.state().position_m).norm(), 1e-9);
        ASSERT_NEAR(got.yaw_rad, plain.state().yaw_rad, 1e-9);
      }
      last_m = admitted_m;
    }
  }
  EXPECT_GT(behind, 20);
  for (const double share : {-1.0, 0.0, 0.25, 0.5, 1.0}) EXPECT_GT(chosen[share], 0) << share;
}

TEST(GuardedReferenceRules, NobodyLooksFartherAheadThanTwentySeconds) {
  MotionLimits limits;
  limits.horizontal_acceleration_mps2 = 0.1;
  GuardedReference guarded(limits);
  ReferenceGovernor plain(limits);
  Reference start;
  start.velocity_mps = {4.0, 0.0, 0.0};
  guarded.reset(start);
  plain.reset(start);
  EXPECT_LT((guarded.rest_local_m() - plain_rest_m(plain)).norm(), 1e-9);
  // Begun anew it does not brake any more.
  const std::vector<HalfSpace> wall = {{Vector3::UnitX(), -5.0}};
  guarded.admit({0, 0, 0}, {9, 0, 0}, wall, {3, 0, 0}, 0.1, 4.0);
  guarded.reset(start);
  Reference goal;
  goal.position_m = {50.0, 0.0, 0.0};
  guarded.step(goal, 0.1, 4.0);
  EXPECT_GT(guarded.step(goal, 0.1, 4.0).velocity_mps.x(), 3.95);
}

}  // namespace
}  // namespace swiftlet
