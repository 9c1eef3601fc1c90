// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/control/motion_limits.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace swiftlet {
namespace {

std::vector<double> numbers_of(const MotionLimits& l) {
  return {l.horizontal_speed_mps, l.horizontal_acceleration_mps2, l.horizontal_jerk_mps3,
          l.vertical_speed_mps,   l.vertical_acceleration_mps2,   l.vertical_jerk_mps3,
          l.heading_rate_radps,   l.heading_acceleration_radps2};
}

MotionLimits set_of(MotionLimitsConfig::Set set) {
  MotionLimitsConfig config;
  config.set = set;
  return config.resolve();
}

// The constraint sets of the MRS UAV system, and room for [Vrba 2025, tab. IV] in any direction.
TEST(MotionLimits, SetsAreThePublishedOnes) {
  using Set = MotionLimitsConfig::Set;
  EXPECT_EQ(numbers_of(set_of(Set::kSlow)), (std::vector<double>{1, 1, 20, 1, 1, 20, 0.5, 1}));
  EXPECT_EQ(numbers_of(set_of(Set::kMedium)), (std::vector<double>{4, 2, 40, 2, 1, 40, 1, 1}));
  EXPECT_EQ(numbers_of(set_of(Set::kFast)), (std::vector<double>{8, 4, 60, 4, 2, 60, 2, 2}));
  const MotionLimits agile = set_of(Set::kAgile);
  EXPECT_GE(agile.vertical_speed_mps, 8.2);
  EXPECT_GE(agile.vertical_acceleration_mps2, 4.5);
  // Each set allows at least what the slower one allows.
  const std::vector<double> faster = numbers_of(agile), fast = numbers_of(set_of(Set::kFast));
  for (std::size_t i = 0; i < fast.size(); ++i) EXPECT_GE(faster[i], fast[i]) << i;
}

TEST(MotionLimits, GivenValueOverridesTheSet) {
  MotionLimitsConfig config;
  double* const given[] = {&config.horizontal_speed_mps,       &config.horizontal_acceleration_mps2,
                           &config.horizontal_jerk_mps3,       &config.vertical_speed_mps,
                           &config.vertical_acceleration_mps2, &config.vertical_jerk_mps3,
                           &config.heading_rate_degps,         &config.heading_acceleration_degps2};
  const std::vector<double> of_set = numbers_of(config.resolve());
  for (std::size_t i = 0; i < std::size(given); ++i) {
    *given[i] = 90.0;
    const std::vector<double> now = numbers_of(config.resolve());
    for (std::size_t k = 0; k < now.size(); ++k) {
      const double expected = k != i ? of_set[k] : i < 6 ? 90.0 : std::numbers::pi / 2.0;
      EXPECT_NEAR(now[k], expected, 1e-12) << i << ' ' << k;
    }
    *given[i] = 0.0;
  }
}

}  // namespace
}  // namespace swiftlet
