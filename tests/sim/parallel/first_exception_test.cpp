// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/parallel/first_exception.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>

#include "swiftlet/sim/parallel/crew.hpp"

namespace swiftlet::sim {
namespace {

constexpr int kParts = 200;  // iterations of the loop

TEST(FirstException, RethrowsNothingWithoutException) {
  Crew crew(4);
  const Crew::Duty duty(crew);
  FirstException failure;
  parallel_for(kParts, 1, [&](int i) { failure.guard(i, [] {}); });
  EXPECT_EQ(failure.part(), -1);
  EXPECT_NO_THROW(failure.rethrow());
}

TEST(FirstException, KeepsExceptionOfLowestPart) {
  for (const int threads : {1, 2, 4}) {
    Crew crew(threads);
    const Crew::Duty duty(crew);
    FirstException failure;
    parallel_for(kParts, 1, [&](int k) {
      const int i = kParts - 1 - k;  // the lowest part runs last
      failure.guard(i, [&] {
        if (i % 50 == 17) throw std::runtime_error("part " + std::to_string(i));
      });
    });
    EXPECT_EQ(failure.part(), 17);
    try {
      failure.rethrow();
      FAIL() << "nothing was thrown by " << threads << " threads";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "part 17");
    }
  }
}

TEST(FirstException, RunsRemainingPartsAfterException) {
  Crew crew(4);
  const Crew::Duty duty(crew);
  FirstException failure;
  std::atomic<int> done = 0;
  parallel_for(kParts, 1, [&](int i) {
    failure.guard(i, [&] {
      if (i == 0) throw std::bad_alloc();
      ++done;
    });
  });
  EXPECT_EQ(done, kParts - 1);
  EXPECT_THROW(failure.rethrow(), std::bad_alloc);
}

}  // namespace
}  // namespace swiftlet::sim
