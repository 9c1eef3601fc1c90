// SPDX-License-Identifier: BSD-3-Clause
// Cells, rules and planner of the rule-based Lloyd algorithm beside their definitions, sample by sample.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "swiftlet/core/guidance/rbl_cell.hpp"
#include "swiftlet/core/guidance/rbl_planner.hpp"
#include "swiftlet/core/guidance/rbl_rules.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

class CellDraws {
 public:
  CellDraws(std::uint64_t seed, std::uint32_t round) : random_(seed, "test.rbl-reference"), round_(round) {}
  double between(double min, double max) { return random_.uniform(min, max, round_, index_++); }
  int below(int end) { return static_cast<int>(end * between(0.0, 1.0)); }
  bool coin() { return below(2) == 1; }
  Vector3 vector(double half) {
    const double x = between(-half, half), y = between(-half, half);
    return {x, y, between(-half, half)};
  }

 private:
  Random random_;
  std::uint32_t round_, index_ = 0;
};

/// Every sample on its own.
struct PlainCell {
  struct Sample {
    Vector3 p_m;
    bool in = true, close = false;  // close: to a border, where single precision may decide otherwise
  };
  PlainCell(double radius_m_in, double step_m, bool planar, const Vector3& lattice_m, double z_low_m, double z_high_m)
      : radius_m(radius_m_in) {
    Vector3 origin_m = lattice_m - step_m * (lattice_m / step_m).array().round().matrix();
    if (planar) origin_m.z() = 0.0;
    const int n = static_cast<int>(radius_m / step_m) + 2;
    for (int k = planar ? 0 : -n; k <= (planar ? 0 : n); ++k) {
      for (int j = -n; j <= n; ++j) {
        for (int i = -n; i <= n; ++i) {
          const Vector3 p_m = origin_m + step_m * Vector3(i, j, k);
          const bool at_height = planar || (p_m.z() >= z_low_m - 1e-6 && p_m.z() <= z_high_m + 1e-6);
          if (p_m.norm() <= radius_m * (1.0 + 1e-8) && at_height) samples.push_back({p_m});
        }
      }
    }
  }
  void keep(const std::function<double(const Vector3&)>& beyond_m) {
    for (Sample& sample : samples) {
      const double d = beyond_m(sample.p_m);
      sample.close = sample.close || std::abs(d) < 1e-5;
      sample.in = sample.in && d <= 0.0;
    }
  }
  int num_in() const {
    return static_cast<int>(std::count_if(samples.begin(), samples.end(), [](const Sample& s) { return s.in; }));
  }
  bool is_clear() const {
    return std::none_of(samples.begin(), samples.end(), [](const Sample& s) { return s.close; });
  }
  Vector3 centroid(const Vector3& destination_m, double beta_m, bool of_all) const {
    double least_m = std::numeric_limits<double>::infinity(), sum = 0.0;
    for (const Sample& s : samples) least_m = std::min(least_m, (s.p_m - destination_m).norm());
    Vector3 moment = Vector3::Zero();
    for (const Sample& s : samples) {
      if (!s.in && !of_all) continue;
      const double weight = std::exp((least_m - (s.p_m - destination_m).norm()) / beta_m);
      sum += weight;
      moment += weight * s.p_m;
    }
    return sum > 0.0 ? Vector3(moment / sum) : Vector3(Vector3::Zero());
  }

  double radius_m;
  std::vector<Sample> samples;
};

void compare(RblCell& cell, const PlainCell& plain, bool excluded, CellDraws& draws) {
  ASSERT_EQ(cell.num_samples(), static_cast<int>(plain.samples.size()));
  int num_in = 0;
  for (int i = 0; i < cell.num_samples(); ++i) {
    const PlainCell::Sample& sample = plain.samples[static_cast<std::size_t>(i)];
    ASSERT_LT((cell.point(i) - sample.p_m).norm(), 1e-6);
    if (!sample.close) {
      ASSERT_EQ(cell.contains(i), sample.in) << sample.p_m.transpose();
    }
    num_in += cell.contains(i);
  }
  ASSERT_EQ(cell.num_partitioned(), num_in);
  ASSERT_EQ(cell.is_empty(), num_in == 0);
  if (!plain.is_clear()) return;

  const Vector3 wanted_m = draws.vector(1.5 * plain.radius_m);
  double least_m = std::numeric_limits<double>::infinity();
  Vector3 low_m = Vector3::Constant(least_m), high_m = -low_m;
  for (const PlainCell::Sample& s : plain.samples) {
    if (!s.in) continue;
    least_m = std::min(least_m, (s.p_m - wanted_m).norm());
    low_m = low_m.cwiseMin(s.p_m);
    high_m = high_m.cwiseMax(s.p_m);
  }
  const int nearest = cell.nearest_partitioned(wanted_m);
  ASSERT_EQ(nearest < 0, num_in == 0);
  if (num_in > 0) {
    ASSERT_TRUE(cell.contains(nearest));
    ASSERT_NEAR((cell.point(nearest) - wanted_m).norm(), least_m, 1e-6);
    if (!excluded) {
      ASSERT_LT((cell.bounds()[0] - low_m).norm(), 1e-6);
      ASSERT_LT((cell.bounds()[1] - high_m).norm(), 1e-6);
    }
  }
  for (const double beta_m : {0.3, 1.5, 20.0}) {
    const Vector3 destination_m = draws.vector(3.0 * plain.radius_m);
    const CellCentroids centroids = cell.centroids(destination_m, beta_m);
    ASSERT_LT((centroids.sensing_agent_m - plain.centroid(destination_m, beta_m, true)).norm(), 2e-5);
    ASSERT_LT((centroids.partitioned_agent_m - plain.centroid(destination_m, beta_m, false)).norm(), 2e-5);
    ASSERT_LT((cell.partitioned_centroid(destination_m, beta_m) - plain.centroid(destination_m, beta_m, false)).norm(),
              2e-5);
  }
  // A vanishing beta leaves the nearest one alone.
  if (num_in == 0) return;
  const Vector3 tended_m = cell.point(cell.nearest_partitioned(wanted_m));
  ASSERT_LT((cell.partitioned_centroid(wanted_m, 1e-4) - tended_m).norm(), 1e-6);
}

TEST(RblCellReference, AfterAnyCutsACellIsWhatSampleBySampleIsLeft) {
  int empty = 0, with_excluded = 0;
  for (std::uint32_t round = 0; round < 300; ++round) {
    CellDraws draws(1, round);
    const bool planar = draws.below(3) == 0;
    const double radius_m = draws.between(0.9, 3.6), step_m = radius_m / draws.between(3.0, planar ? 16.0 : 8.0);
    RblCell cell(radius_m, step_m, planar);
    // Used before: nothing of that is left.
    cell.reset(draws.vector(9.0), -radius_m, 0.3 * radius_m);
    cell.exclude([](const Eigen::Vector3f& q) { return q.x() > 0.0F; });
    const Vector3 lattice_m = draws.coin() ? Vector3(Vector3::Zero()) : draws.vector(7.0);
    double z_low_m = draws.between(-1.2, 0.2) * radius_m, z_high_m = draws.between(0.0, 1.2) * radius_m;
    if (round % 10 == 0) {  // on layers of the lattice
      z_low_m = -2.0 * step_m;
      z_high_m = step_m;
    }
    cell.reset(lattice_m, z_low_m, z_high_m);
    PlainCell plain(radius_m, step_m, planar, lattice_m, z_low_m, z_high_m);
    if (draws.below(4) == 0) {
      ASSERT_NO_FATAL_FAILURE(compare(cell, plain, false, draws)) << round;
    }
    const int num_cuts = 1 + draws.below(5);
    bool excluded = false;
    for (int i = 0; i < num_cuts; ++i) {
      const int kind = draws.below(8);
      if (kind == 0) {
        const Vector3 center_m = draws.vector(0.6 * radius_m);
        const double ball_m = draws.between(0.3, 1.4) * radius_m;
        cell.cut_ball(center_m, ball_m);
        plain.keep([&](const Vector3& q) { return (q - center_m).norm() - ball_m; });
      } else if (kind == 1) {
        const Vector3 normal = draws.vector(1.0);
        const double offset = draws.between(-0.2, 0.8);
        excluded = true;
        cell.exclude([&](const Eigen::Vector3f& q) { return normal.dot(q.cast<double>()) > offset; });
        plain.keep([&](const Vector3& q) { return normal.dot(q) - offset; });
      } else {
        Vector3 normal = draws.vector(1.0);
        if (kind == 2) normal.x() = 0.0;  // along the rows
        const HalfSpace half{normal.normalized(), draws.between(-0.3, 1.1) * radius_m};
        cell.cut(half);
        plain.keep([&](const Vector3& q) { return half.normal_local.dot(q) - half.offset_m; });
      }
      if (draws.below(4) == 0) {
        ASSERT_NO_FATAL_FAILURE(compare(cell, plain, excluded, draws)) << round << ", cut " << i;
      }
    }
    ASSERT_NO_FATAL_FAILURE(compare(cell, plain, excluded, draws)) << round;
    empty += cell.is_empty();
    with_excluded += excluded && !cell.is_empty();
  }
  EXPECT_GT(empty, 20);
  EXPECT_GT(with_excluded, 20);
}

TEST(RblCellReference, SamplesOnTheSphereAndOnPlanesCount) {
  RblCell cell(2.5, 0.5, false);
  PlainCell plain(2.5, 0.5, false, Vector3::Zero(), -2.5, 2.5);
  ASSERT_EQ(cell.num_samples(), static_cast<int>(plain.samples.size()));
  // (1.5, 2, 0) and its like lie on the sphere.
  const auto on_sphere = [](const PlainCell::Sample& s) { return std::abs(s.p_m.norm() - 2.5) < 1e-9; };
  EXPECT_EQ(std::count_if(plain.samples.begin(), plain.samples.end(), on_sphere), 30);
  for (const Vector3& normal : {Vector3(1, 0, 0), Vector3(-1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, -1)}) {
    for (const double offset_m : {-1.0, 0.0, 0.5, 2.5, 2.6}) {
      cell.reset(Vector3::Zero(), -2.5, 2.5);
      cell.cut({normal, offset_m});
      for (int i = 0; i < cell.num_samples(); ++i) {
        ASSERT_EQ(cell.contains(i), normal.dot(cell.point(i)) <= offset_m) << normal.transpose() << " " << offset_m;
      }
    }
  }
}

TEST(RblCellReference, LayersWithinAMicrometerOfTheLimitsOfHeightCount) {
  RblCell cell(2.0, 0.5, false);
  for (const double beyond_m : {0.8e-6, 1.2e-6}) {
    cell.reset(Vector3::Zero(), -2.0, -beyond_m);
    EXPECT_EQ(cell.point(cell.num_samples() - 1).z() == 0.0, beyond_m < 1e-6);
    cell.reset(Vector3::Zero(), beyond_m, 2.0);
    EXPECT_EQ(cell.point(0).z() == 0.0, beyond_m < 1e-6);
  }
}

// Weights are told to a few parts in ten million: of two samples, by where their centroid lies between them.
TEST(RblCellReference, WeightsAreExactToSinglePrecision) {
  RblCell cell(1.0, 0.4, true);  // of its five columns two are left: x = 0 and x = 0.4
  const double y = 0.0;
  double worst = 0.0;
  int compared = 0;
  for (int i = 0; i < 4000; ++i) {
    const double beta_m = 0.05 * std::pow(40.0, i / 4000.0);
    cell.reset(Vector3::Zero(), -1.0, 1.0);
    for (const HalfSpace& half : {HalfSpace{{-1, 0, 0}, 0.2}, HalfSpace{{1, 0, 0}, 0.6}, HalfSpace{{0, 1, 0}, y + 0.2},
                                  HalfSpace{{0, -1, 0}, 0.2 - y}}) {
      cell.cut(half);
    }
    ASSERT_EQ(cell.num_partitioned(), 2);
    const Vector3 destination_m(1.0 + 1e-3 * i, 0.0, 0.0);
    const double x_m = cell.partitioned_centroid(destination_m, beta_m).x();
    // Both lie 0.4 m apart toward it.
    const double ratio = std::exp(-static_cast<double>(0.4F) / beta_m);
    if (ratio < 0.2) continue;
    const double got = (static_cast<double>(0.4F) - x_m) / x_m;
    worst = std::max(worst, std::abs(got / ratio - 1.0));
    ++compared;
  }
  EXPECT_GT(compared, 2000);
  EXPECT_LT(worst, 3e-6);
}

double violation_m(const std::vector<HalfSpace>& cuts, const Vector3& q) {
  double worst_m = 0.0;
  for (const HalfSpace& cut : cuts) worst_m = std::max(worst_m, cut.normal_local.dot(q) - cut.offset_m);
  return worst_m;
}

TEST(RblCellReference, TheLeastViolatingSampleIsTheNearestOfTheBest) {
  for (std::uint32_t round = 0; round < 60; ++round) {
    CellDraws draws(2, round);
    RblCell cell(2.0, 0.31, draws.coin());
    cell.reset(draws.vector(1.0), -2.0, 2.0);
    std::vector<HalfSpace> cuts;
    const int count = 1 + draws.below(5);
    for (int i = 0; i < count; ++i) cuts.push_back({draws.vector(1.0).normalized(), draws.between(-1.0, 0.5)});
    const Vector3 best = cell.least_violating(cuts);
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < cell.num_samples(); ++i) {
      const Vector3 q = cell.point(i);
      least = std::min(least, violation_m(cuts, q) + 1e-6 * q.norm());
    }
    EXPECT_NEAR(violation_m(cuts, best) + 1e-6 * best.norm(), least, 1e-9);
  }
}

// ---- rules

double level_m(const Vector3& v) { return std::hypot(v.x(), v.y()); }

double toward(double from, double to, double most) { return from + std::clamp(to - from, -most, most); }

RblState plain_rules(const RblRules& r, const RblSituation& now, const RblState& state, double dt_s, bool planar) {
  const Vector3 &a = now.partitioned_agent_m, &s = now.sensing_agent_m, &free = now.unrotated_agent_m;
  RblState next;
  // (2.7), and where the goal is in reach
  const bool stuck =
      a.norm() < r.weight_near_m && ((a - s).norm() > r.weight_gap_m || now.goal_agent_m.norm() < r.weight_goal_m);
  next.beta_m = stuck ? state.beta_m - r.weight_rate_mps * dt_s
                      : state.beta_m + std::min(dt_s, 1.0) * (r.beta_desired_m - state.beta_m);
  next.beta_m = std::max(next.beta_m, r.beta_min_m);
  // (2.8) to (2.12)
  if (r.azimuth_rule) {
    const bool is_near = level_m(a)<r.azimuth_near_m, is_far = level_m(a)> r.azimuth_near_m;
    const bool turns = level_m(a - s) > r.azimuth_gap_m &&
                       (r.azimuth_condition == RblRules::AzimuthCondition::kNear ? is_near : is_far);
    next.theta_rad = turns ? toward(state.theta_rad, kPi / 2.0, r.azimuth_rate_radps * dt_s)
                           : toward(state.theta_rad, 0.0, r.azimuth_return_radps * dt_s);
    const bool resets = (r.azimuth_reset == RblRules::AzimuthReset::kDetour && level_m(free) > level_m(a)) ||
                        (r.azimuth_reset == RblRules::AzimuthReset::kNear && level_m(free) > r.azimuth_near_m);
    if (resets && next.theta_rad >= kPi / 2.0) next.theta_rad = 0.0;
  }
  // (2.15) to (2.19)
  if (r.elevation_rule && !planar) {
    const double gap_m = std::abs(a.z() - s.z()), lost_m = level_m(s) - level_m(a);
    const bool apart = r.elevation_condition == RblRules::ElevationCondition::kGap ? gap_m > r.elevation_gap_m
                                                                                   : gap_m < r.elevation_gap_m;
    const bool shrunk =
        lost_m > r.elevation_shrink_m || (r.elevation_shrink_absolute && -lost_m > r.elevation_shrink_m);
    const double step = r.elevation_rate_radps * dt_s;
    if (shrunk || (apart && std::abs(a.z()) < r.elevation_near_m)) {
      const Vector3& g = now.goal_agent_m;
      double north = g.y() / level_m(g);
      if (r.direction_influence == RblRules::DirectionInfluence::kPrinted) north = std::atan2(g.y(), g.x()) / kPi;
      if (r.direction_influence == RblRules::DirectionInfluence::kProgram) {
        double clockwise = std::atan2(g.x(), g.y());
        if (clockwise < 0.0) clockwise += 2.0 * kPi;
        north = clockwise / kPi - 1.0;
      }
      double height_m = s.z();
      if (r.elevation_sense == RblRules::ElevationSense::kLevel) {
        const double goal_rad = std::asin(g.z() / g.norm());
        const double turned_rad = std::min(std::max(goal_rad + state.phi_rad, -kPi / 2.0), kPi / 2.0);
        height_m += s.norm() * (std::sin(goal_rad) - 2.0 * std::sin(turned_rad));
      }
      const bool up = r.centering_weight * height_m + r.direction_weight * north > 0.0;
      next.phi_rad = std::min(std::max(state.phi_rad + (up ? step : -step), -kPi / 4.0), kPi / 4.0);
    } else {
      next.phi_rad = toward(state.phi_rad, 0.0, step);
    }
    if (r.elevation_reset && std::abs(next.phi_rad) >= kPi / 4.0 && std::abs(a.z()) > std::abs(free.z()))
      next.phi_rad = 0.0;
  }
  return next;
}

RblRules drawn_rules(CellDraws& draws) {
  RblRules r;
  r.weight_near_m = draws.between(0.1, 1.0);
  r.weight_gap_m = draws.between(0.1, 1.5);
  r.weight_goal_m = draws.between(0.0, 6.0);
  r.azimuth_near_m = draws.between(0.1, 1.0);
  r.azimuth_gap_m = draws.between(0.1, 1.5);
  r.elevation_near_m = draws.between(0.1, 1.0);
  r.elevation_gap_m = draws.between(0.1, 1.5);
  r.elevation_shrink_m = draws.between(0.0, 1.0);
  r.beta_desired_m = draws.between(0.4, 1.5);
  r.beta_min_m = draws.between(0.1, 0.4);
  r.weight_rate_mps = draws.between(0.1, 2.0);
  r.azimuth_rate_radps = draws.between(0.1, 2.0);
  r.azimuth_return_radps = draws.between(0.1, 3.0);
  r.elevation_rate_radps = draws.between(0.1, 2.0);
  r.centering_weight = draws.between(0.0, 1.0);
  r.direction_weight = draws.between(0.1, 1.0);
  r.azimuth_condition = static_cast<RblRules::AzimuthCondition>(draws.below(2));
  r.azimuth_reset = static_cast<RblRules::AzimuthReset>(draws.below(3));
  r.elevation_condition = static_cast<RblRules::ElevationCondition>(draws.below(2));
  r.elevation_shrink_absolute = draws.coin();
  r.direction_influence = static_cast<RblRules::DirectionInfluence>(draws.below(3));
  r.elevation_sense = static_cast<RblRules::ElevationSense>(draws.below(3));
  r.elevation_reset = draws.coin();
  r.azimuth_rule = draws.below(8) != 0;
  r.elevation_rule = draws.below(8) != 0;
  return r;
}

TEST(RblRulesReference, EveryStepIsThatOfTheEquations) {
  int at_right_angle = 0, at_eighth = 0;
  for (std::uint32_t round = 0; round < 4000; ++round) {
    CellDraws draws(3, round);
    const RblRules rules = drawn_rules(draws);
    RblSituation now;
    now.goal_agent_m = draws.vector(draws.coin() ? 4.0 : 30.0);
    now.partitioned_agent_m = draws.vector(draws.coin() ? 0.5 : 1.5);
    now.sensing_agent_m = draws.vector(2.0);
    now.unrotated_agent_m = draws.vector(1.0);
    RblState state{draws.between(0.1, 2.0), draws.between(0.0, kPi / 2.0), draws.between(-kPi / 4.0, kPi / 4.0)};
    if (draws.below(3) == 0) state.theta_rad = draws.coin() ? kPi / 2.0 : 0.0;
    if (draws.below(3) == 0) state.phi_rad = kPi / 4.0 * (draws.below(3) - 1);
    const double dt_s = draws.coin() ? 0.1 : draws.between(0.01, 1.4);
    const bool planar = draws.below(5) == 0;
    const RblState got = apply_rules(rules, now, state, dt_s, planar);
    const RblState expected = plain_rules(rules, now, state, dt_s, planar);
    ASSERT_NEAR(got.beta_m, expected.beta_m, 1e-12) << round;
    ASSERT_NEAR(got.theta_rad, expected.theta_rad, 1e-12) << round;
    ASSERT_NEAR(got.phi_rad, expected.phi_rad, 1e-12) << round;
    at_right_angle += expected.theta_rad == kPi / 2.0;
    at_eighth += std::abs(expected.phi_rad) == kPi / 4.0;

    // (2.20): turned to the right about the vertical, then up, no farther than the zenith.
    const Vector3 goal = now.goal_agent_m;
    const double sense = rules.elevation_sense == RblRules::ElevationSense::kPrinted ? -1.0 : 1.0;
    const double elevation =
        std::clamp(std::asin(goal.z() / goal.norm()) + sense * state.phi_rad, -kPi / 2.0, kPi / 2.0);
    const double azimuth = std::atan2(goal.y(), goal.x()) - state.theta_rad;
    const Vector3 turned = goal.norm() * Vector3(std::cos(elevation) * std::cos(azimuth),
                                                 std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    ASSERT_LT((rbl_destination(rules, goal, state) - turned).norm(), 1e-6) << round;
  }
  EXPECT_GT(at_right_angle, 50);
  EXPECT_GT(at_eighth, 50);
}

TEST(RblRulesReference, AtTheGoalAndAboveItThereIsNoDirection) {
  EXPECT_EQ(rbl_destination({}, Vector3::Zero(), {1.5, 0.3, 0.2}), Vector3(0, 0, 0));
  RblSituation now;
  now.goal_agent_m = {0, 0, 5};
  now.sensing_agent_m = {0, 0, 0.4};
  RblRules rules;
  for (int i = 0; i < 3; ++i) {
    rules.direction_influence = static_cast<RblRules::DirectionInfluence>(i);
    rules.elevation_sense = RblRules::ElevationSense::kUp;
    EXPECT_NEAR(vertical_influence(rules, now), 0.7 * 0.4, 1e-12);
  }
}

// ---- planner

using Cut = RblCellConfig::Cut;

double plain_offset_m(Cut cut, double d, double Delta, double eta) {
  if (cut == Cut::kBuffered) return (d - Delta) / 2.0;
  if (cut == Cut::kProjected) return d < 2.0 * Delta ? 2.0 * eta * (d - Delta) : eta * d;
  return d < 2.0 * Delta ? d - Delta : Delta + eta * (d - 2.0 * Delta);
}

TEST(RblPlannerReference, CutsAreThoseOfTheirInterpretation) {
  for (std::uint32_t round = 0; round < 400; ++round) {
    CellDraws draws(4, round);
    const Vector3 to_m = draws.vector(3.0);
    const double d = to_m.norm(), Delta = draws.between(0.2, 2.0), eta = draws.between(0.3, 0.99);
    for (const Cut cut : {Cut::kProgram, Cut::kProjected, Cut::kBuffered}) {
      const HalfSpace half = neighbor_cut(to_m, Delta, eta, cut);
      ASSERT_LT((half.normal_local - to_m.normalized()).norm(), 1e-12);
      ASSERT_NEAR(half.offset_m, plain_offset_m(cut, d, Delta, eta), 1e-12) << static_cast<int>(cut);
    }
    const HalfSpace obstacle = obstacle_cut(to_m, Delta, eta);
    ASSERT_LT((obstacle.normal_local - to_m.normalized()).norm(), 1e-12);
    ASSERT_NEAR(obstacle.offset_m, plain_offset_m(Cut::kProgram, d, Delta, eta), 1e-12);
  }
  // Two in one place part along x.
  EXPECT_EQ(neighbor_cut(Vector3(0, 1e-7, 0), 1.0, 0.9, Cut::kProgram).normal_local, Vector3(1, 0, 0));
  EXPECT_EQ(neighbor_cut(Vector3(0, 1.2e-6, 0), 1.0, 0.9, Cut::kProgram).normal_local.x(), 0.0);
}

TEST(RblPlannerReference, EveryUpdateIsThatOfCellRulesAndDestination) {
  int turned = 0, empty = 0, printed = 0;
  for (std::uint32_t round = 0; round < 60; ++round) {
    CellDraws draws(5, round);
    RblCellConfig config;
    config.sensing_radius_m = draws.between(2.0, 4.0);
    config.step_m = config.sensing_radius_m / draws.between(6.0, 10.0);
    config.encumbrance_m = draws.between(0.3, 0.6);
    config.eta = draws.between(0.5, 0.95);
    config.cut = static_cast<Cut>(draws.below(4));
    config.lattice = draws.coin() ? RblCellConfig::Lattice::kAgent : RblCellConfig::Lattice::kWorld;
    RblRules rules = drawn_rules(draws);
    const bool planar = draws.below(4) == 0;
    RblPlanner planner(config, rules, planar);
    RblState state;
    state.beta_m = rules.beta_desired_m;
    const double Delta = 2.0 * config.encumbrance_m, r = config.sensing_radius_m, step = config.step_m;
    for (int update = 0; update < 8; ++update) {
      const Vector3 p_m = draws.vector(6.0);
      const double z_min_m = draws.between(-9.0, 3.0), z_max_m = z_min_m + draws.between(0.5, 8.0);
      std::vector<Vector3> others_m;
      const int count = draws.below(6);
      for (int i = 0; i < count; ++i) others_m.push_back(p_m + draws.vector(draws.coin() ? 1.0 : 4.0));
      planner.partition(p_m, others_m, z_min_m, z_max_m);

      // Who is out of its heights keeps a layer beside them.
      PlainCell plain(r, step, planar,
                      config.lattice == RblCellConfig::Lattice::kWorld ? Vector3(-p_m) : Vector3(Vector3::Zero()),
                      std::min(z_min_m - p_m.z(), r - step), std::max(z_max_m - p_m.z(), step - r));
      std::size_t num_cuts = 0;
      for (const Vector3& other_m : others_m) {
        Vector3 to_m = other_m - p_m;
        if (planar) to_m.z() = 0.0;
        const double d = to_m.norm();
        if (d > r / config.eta + Delta) continue;
        const HalfSpace cut = planner.cuts().at(num_cuts++);
        ASSERT_LT((cut.normal_local - to_m / d).norm(), 1e-9);
        if (config.cut != Cut::kPrinted) {
          const double expected_m = plain_offset_m(config.cut, d, Delta, config.eta);
          ASSERT_NEAR(cut.offset_m, expected_m, 1e-9);
          plain.keep([&](const Vector3& q) { return to_m.dot(q) / d - expected_m; });
          continue;
        }
        ++printed;
        // Nearer to the agent than eta times to the other, who counts as nearer when both overlap.
        const double mirrored = d >= 2.0 * Delta ? d : 2.0 * (d - Delta);
        if (mirrored > 0.0) {
          ASSERT_NEAR(cut.offset_m, config.eta / (1.0 + config.eta) * mirrored, 1e-9);
          plain.keep([&](const Vector3& q) { return q.norm() - config.eta * (q - to_m * (mirrored / d)).norm(); });
        } else {
          ASSERT_NEAR(cut.offset_m, d - Delta, 1e-9);
          plain.keep([&](const Vector3& q) { return to_m.dot(q) / d - (d - Delta); });
        }
      }
      ASSERT_EQ(num_cuts, planner.cuts().size());
      const bool is_clear = plain.is_clear();
      ASSERT_NO_FATAL_FAILURE({
        CellDraws same(6, round);
        compare(planner.cell(), plain, false, same);
      }) << round;

      const double dt_s = draws.between(0.05, 0.6);
      Vector3 to_goal_m = draws.vector(9.0);
      const RblPlanner::Step got = planner.update(p_m + to_goal_m, dt_s);
      if (planar) to_goal_m.z() = 0.0;
      RblSituation now;
      now.goal_agent_m = to_goal_m;
      const Vector3 destination_m = rbl_destination(rules, to_goal_m, state);
      now.sensing_agent_m = plain.centroid(destination_m, state.beta_m, true);
      now.partitioned_agent_m = plain.centroid(destination_m, state.beta_m, false);
      now.unrotated_agent_m = plain.centroid(to_goal_m, state.beta_m, false);
      if (plain.num_in() == 0)
        now.partitioned_agent_m = now.unrotated_agent_m = planner.cell().least_violating(planner.cuts());
      ASSERT_EQ(got.empty_cell, planner.cell().is_empty());
      if (is_clear) {
        ASSERT_LT((got.centroid_local_m - p_m - now.partitioned_agent_m).norm(), 1e-4) << round;
        ASSERT_LT((got.sensing_local_m - p_m - now.sensing_agent_m).norm(), 1e-4);
        ASSERT_LT((got.unrotated_local_m - p_m - now.unrotated_agent_m).norm(), 1e-4);
      }
      // From what it says of the centroids the rules follow.
      now.partitioned_agent_m = got.centroid_local_m - p_m;
      now.sensing_agent_m = got.sensing_local_m - p_m;
      now.unrotated_agent_m = got.unrotated_local_m - p_m;
      const RblState expected = apply_rules(rules, now, state, dt_s, planar);
      ASSERT_NEAR(planner.state().beta_m, expected.beta_m, 1e-6);
      ASSERT_NEAR(planner.state().theta_rad, expected.theta_rad, 1e-6);
      ASSERT_NEAR(planner.state().phi_rad, expected.phi_rad, 1e-6);
      state = planner.state();
      ASSERT_LT((got.destination_local_m - p_m - rbl_destination(rules, to_goal_m, state)).norm(), 1e-9);
      turned += state.theta_rad > 0.0;
      empty += got.empty_cell;
    }
  }
  EXPECT_GT(turned, 30);
  EXPECT_GT(empty, 5);
  EXPECT_GT(printed, 30);
}

}  // namespace
}  // namespace swiftlet
