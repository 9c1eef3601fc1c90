// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/capture_judge.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace swiftlet {
namespace {

CaptureVolume net() { return {.offset_m = {0.0, 0.0, -1.6}, .radius_m = 2.0, .height_m = 0.5, .rearm_m = 4.0}; }

/// Moves a target straight from one side of the net to the other, at a distance from its axis and a height.
bool passes(CaptureJudge& judge, double miss_m, double height_m, std::optional<double> unmeasured_s = 0.1) {
  bool captured = false;
  judge.forget();
  for (const double x_m : {-5.0, -3.0, -1.0, 1.0, 3.0, 5.0})
    captured = judge.captures({7, {x_m, miss_m, height_m}, unmeasured_s}) || captured;
  return captured;
}

TEST(CaptureJudge, CountsTargetsThroughTheWholeNet) {
  for (const double miss_m : {0.0, 1.9, 2.1}) {
    for (const double height_m : {-0.3, -0.2, 0.2, 0.3}) {
      CaptureJudge judge(net());
      EXPECT_EQ(passes(judge, miss_m, height_m), miss_m < 2.0 && std::abs(height_m) < 0.25)
          << miss_m << " " << height_m;
    }
  }
}

TEST(CaptureJudge, NeedsARecentMeasurement) {
  CaptureJudge judge(net());
  EXPECT_FALSE(passes(judge, 0.0, 0.0, std::nullopt)) << "the track only continues by prediction";
  EXPECT_FALSE(passes(judge, 0.0, 0.0, 1.1));
  EXPECT_TRUE(passes(judge, 0.0, 0.0, 0.9)) << "a level LiDAR does not see its net";
}

TEST(CaptureJudge, CountsAgainBeyondRearmDistance) {
  CaptureJudge judge(net());
  const auto at = [&](double x_m) { return judge.captures({7, {x_m, 0.0, 0.0}, 0.0}); };
  EXPECT_FALSE(at(3.0));
  EXPECT_TRUE(at(1.0));
  EXPECT_FALSE(judge.is_armed());
  for (const double x_m : {3.0, 1.0, 3.0, 4.1, 3.0}) EXPECT_FALSE(at(x_m)) << x_m;
  EXPECT_TRUE(at(1.0));
  EXPECT_EQ(judge.num_captures(), 2);
}

TEST(CaptureJudge, IgnoresJumpsBetweenTracks) {
  CaptureJudge judge(net());
  EXPECT_FALSE(judge.captures({7, {-3.0, 0.0, 0.0}, 0.0}));
  EXPECT_FALSE(judge.captures({8, {3.0, 0.0, 0.0}, 0.0})) << "another track";
  judge.forget();
  EXPECT_FALSE(judge.captures({8, {-3.0, 0.0, 0.0}, 0.0})) << "the track was lost in between";
}

}  // namespace
}  // namespace swiftlet
