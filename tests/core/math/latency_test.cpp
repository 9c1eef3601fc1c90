// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/math/latency.hpp"

#include <gtest/gtest.h>

namespace swiftlet {
namespace {

TEST(Worker, IsBusyUntilItsLatencyElapses) {
  Worker worker(0.1);
  EXPECT_TRUE(worker.idle());
  EXPECT_FALSE(worker.due(kNsPerSecond));
  worker.start(kNsPerSecond);
  EXPECT_FALSE(worker.idle());
  EXPECT_FALSE(worker.due(kNsPerSecond + 99'999'999));
  EXPECT_TRUE(worker.due(kNsPerSecond + 100'000'000));
  worker.stop();
  EXPECT_TRUE(worker.idle());
  EXPECT_FALSE(worker.due(2 * kNsPerSecond));
}

TEST(Worker, WithoutLatencyIsDueAtOnce) {
  Worker worker(0.0);
  worker.start(5);
  EXPECT_TRUE(worker.due(5));
}

}  // namespace
}  // namespace swiftlet
