// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/episode_list.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(EpisodeList, SortsNumbersAndRangesWithoutDuplicates) {
  EXPECT_THAT(parse_episodes("7", 8), ElementsAre(7));
  EXPECT_THAT(parse_episodes("17,3,15-18,0", 19), ElementsAre(0, 3, 15, 16, 17, 18));
}

TEST(EpisodeList, WhatIsNoListIsRefused) {
  for (const char* text : {"", ",", "3,", "a", "5-3", "-3", "3-", "1 2", "1.5"}) {
    EXPECT_THROW(parse_episodes(text, 100), InputError) << text;
  }
}

TEST(EpisodeList, RefusesMissingEpisodeAndNamesRange) {
  try {
    parse_episodes("3,90-100", 100);
    FAIL() << "100 is none of 100 episodes";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("below 100, found 100"));
  }
}

}  // namespace
}  // namespace swiftlet::sim
