// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/dead_reckoning.hpp"

#include <gtest/gtest.h>

#include "swiftlet/core/base/gravity.hpp"

namespace swiftlet {
namespace {

// From a past state all later samples are applied, including the newest.
TEST(DeadReckoning, ReplaysLaterSamplesAfterARestart) {
  constexpr TimeNs kStep = 10'000'000;
  DeadReckoning reckoning;
  NavState start;
  start.t = 0;
  reckoning.restart(start);
  const auto sample = [&](int i) {
    return ImuSample{i * kStep, Vector3::Zero(), Vector3(0.3 * i, 0.0, kGravity_mps2)};
  };
  for (int i = 1; i <= 10; ++i) reckoning.push(sample(i));
  for (const int from : {0, 4, 9, 10}) {
    NavState past;
    past.t = from * kStep;
    reckoning.restart(past);
    double v_mps = 0.0;  // the sum of the accelerations since then
    for (int i = from + 1; i <= 10; ++i) v_mps += 0.01 * 0.3 * i;
    const NavState now = reckoning.at(10 * kStep);
    EXPECT_EQ(now.t, 10 * kStep);
    EXPECT_NEAR(now.v_mps.x(), v_mps, 1e-12) << from;
  }
}

}  // namespace
}  // namespace swiftlet
