// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/foliage.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "swiftlet/sim/world/field.hpp"
#include "swiftlet/sim/world/forest.hpp"

namespace swiftlet::sim {
namespace {

FoliageConfig breeze() {
  FoliageConfig config;
  config.sway_m = 0.4;
  config.flutter_m = 0.05;
  return config;
}

/// Frequency of A sin(2 pi f t + b), by x(t + h) + x(t - h) = 2 cos(2 pi f h) x(t) where |x| is greatest.
template <class Curve>
double frequency_hz(const Curve& curve, double longest_s, double step_s) {
  double at_s = 0.0;
  for (double t_s = 0.0; t_s < longest_s; t_s += step_s)
    at_s = std::abs(curve(t_s)) > std::abs(curve(at_s)) ? t_s : at_s;
  const double cosine = (curve(at_s + step_s) + curve(at_s - step_s)) / (2.0 * curve(at_s));
  return std::acos(std::clamp(cosine, -1.0, 1.0)) / (2.0 * std::numbers::pi * step_s);
}

template <class Curve>
void expect_harmonic(const Curve& curve, double amplitude, double hz) {
  const double found_hz = frequency_hz(curve, 2.0 / hz, 0.05 / hz);
  EXPECT_GE(found_hz, 0.8 * hz - 1e-9);
  EXPECT_LE(found_hz, 1.25 * hz + 1e-9);
  const double omega = 2.0 * std::numbers::pi * found_hz, h = 0.07 / hz;
  const double sine = (curve(h) - curve(0.0) * std::cos(omega * h)) / std::sin(omega * h), cosine = curve(0.0);
  EXPECT_NEAR(std::hypot(sine, cosine), amplitude, 1e-6 * amplitude);
  for (int i = 0; i < 200; ++i) {
    const double t_s = 0.37 * i;
    EXPECT_NEAR(curve(t_s), sine * std::sin(omega * t_s) + cosine * std::cos(omega * t_s), 1e-5 * amplitude) << t_s;
  }
}

TEST(Foliage, SwaysTreesAlongTheWind) {
  const FoliageMotion motion(breeze(), 7);
  for (const std::uint32_t tree : {0U, 1U, 500U}) {
    expect_harmonic([&](double t_s) { return motion.sway_m(tree, t_s).x(); }, 0.4, 0.3);
    expect_harmonic([&](double t_s) { return motion.sway_m(tree, t_s).y(); }, 0.2, 0.3);
    EXPECT_EQ(motion.sway_m(tree, 3.0).z(), 0.0);
  }
}

TEST(Foliage, LeavesFlutterHarmonicallyByEachAxis) {
  const FoliageMotion motion(breeze(), 7);
  for (const std::uint32_t pattern : {0U, 17U, 255U}) {
    for (int axis = 0; axis < 3; ++axis) {
      expect_harmonic([&](double t_s) { return motion.flutter_m(pattern, t_s)[axis]; }, axis == 2 ? 0.025 : 0.05, 2.0);
    }
  }
}

TEST(Foliage, KeepsLeavesWithinTheirReach) {
  const FoliageConfig config = breeze();
  const FoliageMotion motion(config, 11);
  EXPECT_NEAR(config.reach_m(), std::sqrt(1.25) * 0.4 + std::sqrt(2.25) * 0.05, 1e-12);
  double farthest_m = 0.0;
  for (std::uint32_t k = 0; k < 50; ++k) {
    for (int i = 0; i < 400; ++i) {
      const double t_s = 0.173 * i;
      farthest_m = std::max(farthest_m, (motion.sway_m(k, t_s) + motion.flutter_m(k, t_s)).norm());
    }
  }
  EXPECT_LE(farthest_m, config.reach_m());
  EXPECT_GE(farthest_m, 0.8 * config.reach_m());
}

TEST(Foliage, BendsClampedBeamsBySquaredHeight) {
  EXPECT_EQ(FoliageMotion::share_of_sway(-0.1), 0.0);
  EXPECT_EQ(FoliageMotion::share_of_sway(0.0), 0.0);
  EXPECT_EQ(FoliageMotion::share_of_sway(0.5), 0.25);
  EXPECT_EQ(FoliageMotion::share_of_sway(1.2), 1.0);
}

TEST(Foliage, IsAPureFunctionOfArguments) {
  const FoliageMotion a(breeze(), 7), b(breeze(), 7), other(breeze(), 8);
  EXPECT_EQ(a.sway_m(3, 12.5), b.sway_m(3, 12.5));
  EXPECT_NE(a.sway_m(3, 12.5), other.sway_m(3, 12.5));
  EXPECT_NE(a.sway_m(3, 12.5), a.sway_m(4, 12.5));
  int leaves[FoliageMotion::kNumPatterns] = {};
  for (std::uint32_t leaf = 0; leaf < 25'600; ++leaf) ++leaves[a.pattern_of(3, leaf)];
  EXPECT_GT(*std::min_element(std::begin(leaves), std::end(leaves)), 50)
      << "smallest number of leaves per pattern; 100 on average";
  EXPECT_LT(*std::max_element(std::begin(leaves), std::end(leaves)), 160);
}

TEST(Foliage, WorldsHandItToTheirScene) {
  ForestConfig forest;
  forest.size_m = {10.0, 10.0};
  forest.surroundings_m = 0.0;
  EXPECT_FALSE(make_forest(forest, 3).foliage.moves()) << "leaves do not move by default";
  forest.foliage = breeze();
  const Scene scene = make_forest(forest, 3);
  EXPECT_EQ(scene.foliage.sway_m, 0.4);
  EXPECT_EQ(scene.foliage_seed, 3U);
  FieldConfig field;
  field.num_trees = 0;
  field.foliage.flutter_m = 0.1;
  EXPECT_TRUE(make_field(field, 3).foliage.moves());
}

}  // namespace
}  // namespace swiftlet::sim
