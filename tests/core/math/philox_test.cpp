// SPDX-License-Identifier: BSD-3-Clause
// Every number by its definition: Philox4x32-10 of Salmon et al. 2011 written out, and what is made of its words.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

using Words = std::array<std::uint32_t, 4>;

Words philox(Words c, std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53} * c[0], b = std::uint64_t{0xCD9E8D57} * c[2];
    c = {static_cast<std::uint32_t>(b >> 32) ^ c[1] ^ key[0], static_cast<std::uint32_t>(b),
         static_cast<std::uint32_t>(a >> 32) ^ c[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key[0] += 0x9E3779B9;
    key[1] += 0xBB67AE85;
  }
  return c;
}

TEST(Philox, IsThatOfItsAuthors) {
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

/// The words of a draw. Kinds: 0 uniform() and normal(), 1 normal3(), 2 fill_uniform(), 3 fill_normal().
struct Draws {
  std::uint64_t seed;
  std::string_view purpose, entity;

  Words words(std::uint32_t kind, std::uint32_t tick, std::uint32_t index) const {
    return philox({index, tick, stream_id(entity), stream_id(purpose) ^ (kind * 0x9E3779B9U)},
                  {static_cast<std::uint32_t>(seed & 0xFFFFFFFFU), static_cast<std::uint32_t>(seed >> 32U)});
  }
  /// 53 bits of two words, in [0, 1).
  static double unit(std::uint32_t high, std::uint32_t low) {
    return (high + (low >> 11U) * std::exp2(-21.0)) * std::exp2(-32.0);
  }
  static double unit24(std::uint32_t word) { return (word >> 8U) * std::exp2(-24.0); }
};

TEST(Random, NumbersAreThoseOfTheirDefinition) {
  const double turn = 2.0 * std::numbers::pi;
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{7}, std::uint64_t{0xFEDCBA9876543210}}) {
    const Draws draws{seed, "test.philox", "uav1"};
    const Random random(seed, draws.purpose, draws.entity);
    for (std::uint32_t i = 0; i < 200; ++i) {
      const std::uint32_t tick = 3 * i + (i % 7 == 0 ? 0x80000000U : 0U), index = i * i;
      const Words w = draws.words(0, tick, index), w3 = draws.words(1, tick, index);
      EXPECT_EQ(random.bits(tick, index), w);
      EXPECT_NEAR(random.uniform(tick, index), Draws::unit(w[0], w[1]), 2e-16);
      EXPECT_NEAR(random.uniform(-2.0, 5.0, tick, index), 7.0 * Draws::unit(w[0], w[1]) - 2.0, 1e-14);
      const double step = std::exp2(-53.0), u = Draws::unit(w[0], w[1]) + step, v = Draws::unit(w[2], w[3]) + step;
      EXPECT_NEAR(random.normal(tick, index), std::sqrt(-2.0 * std::log(u)) * std::cos(turn * v), 1e-13);
      const auto unit = [&](int k) { return (w3[static_cast<std::size_t>(k)] + 1.0) * std::exp2(-32.0); };
      const double first = std::sqrt(-2.0 * std::log(unit(0))), second = std::sqrt(-2.0 * std::log(unit(2)));
      const auto three = random.normal3(tick, index);
      EXPECT_NEAR(three[0], first * std::cos(turn * unit(1)), 1e-13);
      EXPECT_NEAR(three[1], first * std::sin(turn * unit(1)), 1e-13);
      EXPECT_NEAR(three[2], second * std::cos(turn * unit(3)), 1e-13);
    }
  }
}

TEST(Random, FilledNumbersAreThoseOfTheirDefinition) {
  const double turn = 2.0 * std::numbers::pi;
  const Draws draws{11, "test.philox", {}};
  const Random random(11, draws.purpose);
  for (const std::uint32_t first : {0U, 1U, 6U, 0xFFFFFF00U}) {
    std::vector<float> uniform(101), normal(101);
    random.fill_uniform(5, first, uniform);
    random.fill_normal(5, first, normal);
    for (std::uint32_t k = 0; k < 101; ++k) {
      const std::uint32_t i = first + k;
      EXPECT_EQ(uniform[k], Draws::unit24(draws.words(2, 5, i / 4)[i % 4]));
      const Words w = draws.words(3, 5, i / 4);
      const double u = Draws::unit24(w[i % 4 / 2 * 2]) + std::exp2(-24.0), v = Draws::unit24(w[i % 4 / 2 * 2 + 1]);
      const double radius = std::sqrt(-2.0 * std::log(u));
      EXPECT_NEAR(normal[k], radius * (i % 2 == 0 ? std::cos(turn * v) : std::sin(turn * v)), 2e-6) << i;
    }
  }
}

}  // namespace
}  // namespace swiftlet
