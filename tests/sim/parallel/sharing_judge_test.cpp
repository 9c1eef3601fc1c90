// SPDX-License-Identifier: BSD-3-Clause
#include "sim/parallel/sharing_judge.hpp"

#include <gtest/gtest.h>

namespace swiftlet::sim {
namespace {

constexpr double kSpan_s = 0.025;

/// A machine on which a thread does so many loops in a span, and with its helpers so many.
struct Machine {
  int alone, shared;
};

/// The share of all loops that are done with helpers, and how many loops are done in all, over so many spans.
struct Flown {
  double shared, loops_per_span;
};

Flown fly(SharingJudge& judge, Machine machine, int num_spans, bool contended) {
  int shared = 0;
  double loops = 0.0;
  for (int i = 0; i < num_spans; ++i) {
    const int done = judge.share() ? machine.shared : machine.alone;
    shared += judge.share() ? 1 : 0;
    loops += done;
    judge.learn(done, kSpan_s, contended);
  }
  return {static_cast<double>(shared) / num_spans, loops / num_spans};
}

TEST(SharingJudge, SharesAndTriesNothingWhileNobodyElseWantsTheProcessors) {
  SharingJudge judge;
  EXPECT_TRUE(judge.share());
  EXPECT_EQ(fly(judge, {200, 100}, 1000, false).shared, 1.0) << "not even where it would not pay";
}

TEST(SharingJudge, ABriefInterruptionTriesNothing) {
  SharingJudge judge;
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(fly(judge, {200, 100}, 5, true).shared, 1.0);
    EXPECT_EQ(fly(judge, {200, 100}, 5, false).shared, 1.0);
  }
}

TEST(SharingJudge, KeepsToTheFasterWayBesideOthers) {
  SharingJudge alone_pays;
  fly(alone_pays, {100, 80}, 20, true);
  const Flown alone = fly(alone_pays, {100, 80}, 2000, true);
  EXPECT_LT(alone.shared, 0.1);
  EXPECT_GT(alone.loops_per_span, 98.0);

  SharingJudge sharing_pays;
  const Flown shared = fly(sharing_pays, {80, 100}, 2000, true);
  EXPECT_GT(shared.shared, 0.9);
  EXPECT_LT(shared.shared, 1.0) << "it has to try";
  EXPECT_GT(shared.loops_per_span, 98.0);
}

TEST(SharingJudge, ChangesItsMindWhenTheMachineDoes) {
  SharingJudge judge;
  fly(judge, {100, 80}, 2000, true);
  ASSERT_LT(fly(judge, {100, 80}, 400, true).shared, 0.1);
  fly(judge, {80, 100}, 400, true);
  EXPECT_GT(fly(judge, {80, 100}, 2000, true).shared, 0.9);
  fly(judge, {100, 80}, 400, true);
  EXPECT_LT(fly(judge, {100, 80}, 2000, true).shared, 0.1);
}

TEST(SharingJudge, SharesAgainSoonAfterTheOthersHaveGone) {
  SharingJudge judge;
  fly(judge, {100, 80}, 2000, true);
  fly(judge, {100, 150}, 30, false);
  EXPECT_EQ(fly(judge, {100, 150}, 1000, false).shared, 1.0);
}

// The first spans after a change are still affected by the former mode: here they are three times as slow.
TEST(SharingJudge, TheSpansRightAfterATurnDoNotCount) {
  SharingJudge judge;
  int shared = 0, since_turn = 0;
  bool before = true;
  for (int i = 0; i < 2000; ++i) {
    since_turn = judge.share() == before ? since_turn + 1 : 0;
    before = judge.share();
    shared += before ? 1 : 0;
    const int settled = before ? 80 : 100;
    judge.learn(since_turn < 2 ? settled / 3 : settled, kSpan_s, true);
  }
  EXPECT_LT(shared, 200);
}

}  // namespace
}  // namespace swiftlet::sim
