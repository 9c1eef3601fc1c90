// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/moved_things.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace swiftlet {
namespace {

constexpr TimeNs kSweep = 100'000'000;

TEST(MovedThings, SwayingThingsHaveNotMoved) {
  MovedThings things;
  for (int k = 0; k < 30; ++k) {
    const MovedThings::Motion motion = things.see(k * kSweep, {4.0 + 0.3 * (k % 2), 1.0, 1.0}, k > 5);
    EXPECT_FALSE(motion.has_moved);
    EXPECT_EQ(motion.seen_for, k * kSweep);
  }
}

TEST(MovedThings, SlowThingsMoveInTime) {
  MovedThings things;
  for (int k = 0; k < 60; ++k) {
    const bool has_moved = things.see(k * kSweep, {4.0, 1.0 + 0.02 * std::min(k, 40), 1.0}, false).has_moved;
    EXPECT_EQ(has_moved, k > 25) << "0.5 m after 25 sweeps, then it hovers";
  }
}

TEST(MovedThings, ThingsInFreeAirCameThere) {
  MovedThings things;
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(things.see(k * kSweep, {4.0, 1.0, 1.0}, k == 0).has_moved);
}

TEST(MovedThings, AreForgottenWhenUnseen) {
  MovedThings things;
  things.see(0, {4.0, 1.0, 1.0}, true);
  EXPECT_FALSE(things.see(30 * kSweep, {4.0, 1.0, 1.0}, false).has_moved);
}

}  // namespace
}  // namespace swiftlet
