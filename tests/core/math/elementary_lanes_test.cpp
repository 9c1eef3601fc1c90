// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/math/elementary_lanes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

TEST(Elementary, LogarithmMatchesTheStandardLibrary) {
  const Random random(1, "test.log");
  Lanes2d u(1.0, 0.5);
  EXPECT_EQ(log_of_unit(u)[0], 0.0);
  for (std::uint32_t i = 0; i < 200'000; ++i) {
    u = {u[1], std::ldexp(1.0 - random.uniform(0, i), -static_cast<int>(i % 60))};
    ASSERT_NEAR(log_of_unit(u)[1] / std::log(u[1]), 1.0, 1e-15) << u[1];
    ASSERT_EQ(log_of_unit(u)[1], log_of_unit({u[1], 0.25})[0]) << "lanes differ at " << u[1];
  }
  for (const double x : {1.0 - 0x1p-53, 0x1p-53, 0x1p-32, 0.5, std::numbers::sqrt2 / 2.0, 1e-300}) {
    EXPECT_NEAR(log_of_unit({x, x})[0] / std::log(x), 1.0, 1e-15) << x;
  }
}

TEST(Elementary, SineAndCosineMatchStandardLibrary) {
  const Random random(1, "test.turns");
  for (std::uint32_t i = 0; i < 200'000; ++i) {
    const Lanes2d turns(random.uniform(0.0, 3.0, 0, i), random.uniform(0, i));
    const auto [sine, cosine] = sincos_of_turns(turns);
    for (int lane = 0; lane < 2; ++lane) {  // theirs has the rounded angle's error
      ASSERT_NEAR(sine[lane], std::sin(2.0 * std::numbers::pi * turns[lane]), 4e-15) << turns[lane];
      ASSERT_NEAR(cosine[lane], std::cos(2.0 * std::numbers::pi * turns[lane]), 4e-15) << turns[lane];
    }
    ASSERT_NEAR(sine[0] * sine[0] + cosine[0] * cosine[0], 1.0, 5e-16) << turns[0];
  }
  for (int eighth = 0; eighth <= 16; ++eighth) {  // where the quarters meet
    const auto [sine, cosine] = sincos_of_turns(Lanes2d::Constant(eighth / 8.0));
    EXPECT_NEAR(sine[0], std::sin(std::numbers::pi * eighth / 4.0), 2e-15) << eighth;
    EXPECT_NEAR(cosine[1], std::cos(std::numbers::pi * eighth / 4.0), 2e-15) << eighth;
    EXPECT_EQ(sine[1] == 0.0, eighth % 4 == 0) << eighth;
  }
}

TEST(ElementaryLanes, FourAnglesMatchScalarBitsExactly) {
  const Random random(3, "test", "angles");
  for (std::uint32_t i = 0; i < 100'000; ++i) {
    Lanes4d angle_rad;
    for (std::uint32_t lane = 0; lane < 4; ++lane)
      angle_rad[lane] = random.uniform(-1.0, 1.0, lane, i) * (i % 2 == 0 ? 7.0 : 1e5);
    if (i == 0) angle_rad = Lanes4d{0.0, -0.0, std::numbers::pi / 4.0, -std::numbers::pi / 2.0};
    const auto [sine, cosine] = sincos(angle_rad);
    for (int lane = 0; lane < 4; ++lane) {
      ASSERT_EQ(std::bit_cast<std::uint64_t>(sine[lane]),
                std::bit_cast<std::uint64_t>(elementary::sin(angle_rad[lane])));
      ASSERT_EQ(std::bit_cast<std::uint64_t>(cosine[lane]),
                std::bit_cast<std::uint64_t>(elementary::cos(angle_rad[lane])));
    }
  }
}

}  // namespace
}  // namespace swiftlet
