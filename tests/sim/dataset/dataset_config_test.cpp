// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/dataset/dataset_config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "swiftlet/sim/dataset/flight.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr const char* kSmallDataset = SWIFTLET_SOURCE_DIR "/tests/dataset/small/small.yaml";

using Law = VariationConfig::Law;

FamilyConfig family_with(const std::string& key, Law law, double min, double max,
                         const std::vector<std::string>& choices = {}) {
  VariationConfig variation;
  variation.key = key;
  variation.law = law;
  variation.min = min;
  variation.max = max;
  variation.choices = choices;
  FamilyConfig family;
  family.vary = {variation};
  return family;
}

std::string drawn(const FamilyConfig& family, std::uint64_t seed) {
  return draw_overrides(family, 1, seed, 0).at(0).second;
}

TEST(DatasetDraws, StayInTheirRangesAndCoverThem) {
  const FamilyConfig uniform = family_with("a", Law::kUniform, -2.0, 3.0);
  const FamilyConfig log_uniform = family_with("b", Law::kLogUniform, 0.01, 100.0);
  const FamilyConfig whole = family_with("c", Law::kWhole, 2.0, 4.0);
  const FamilyConfig choice = family_with("d", Law::kChoice, 0.0, 1.0, {"x", "y"});
  double sum = 0.0;
  int below_one = 0;
  std::set<std::string> wholes, words;
  constexpr int kDraws = 2000;
  for (std::uint64_t seed = 0; seed < kDraws; ++seed) {
    const double u = std::stod(drawn(uniform, seed));
    EXPECT_GE(u, -2.0);
    EXPECT_LE(u, 3.0);
    sum += u;
    below_one += std::stod(drawn(log_uniform, seed)) < 1.0 ? 1 : 0;
    wholes.insert(drawn(whole, seed));
    words.insert(drawn(choice, seed));
  }
  // Mean 0.5 with a standard error of 5 / sqrt(12 * 2000); the median of the other is 1. Four standard errors.
  EXPECT_NEAR(sum / kDraws, 0.5, 4.0 * 5.0 / std::sqrt(12.0 * kDraws));
  EXPECT_NEAR(below_one / static_cast<double>(kDraws), 0.5, 4.0 * 0.5 / std::sqrt(kDraws));
  EXPECT_EQ(wholes, (std::set<std::string>{"2", "3", "4"}));
  EXPECT_EQ(words, (std::set<std::string>{"x", "y"}));
}

TEST(DatasetDraws, EveryVehicleHasItsOwnAndAddingOneChangesNone) {
  const auto family = family_with("vehicles[*].airframe.reflectivity", Law::kUniform, 0.0, 1.0);
  const auto two = draw_overrides(family, 2, 7, 0);
  const auto three = draw_overrides(family, 3, 7, 0);
  ASSERT_EQ(two.size(), 2U);
  ASSERT_EQ(three.size(), 3U);
  EXPECT_EQ(three[2].first, "vehicles[2].airframe.reflectivity");
  EXPECT_EQ(two[0], three[0]);
  EXPECT_EQ(two[1], three[1]);
  EXPECT_NE(two[0].second, two[1].second);
}

TEST(DatasetDraws, AreAFunctionOfSeedAndAttempt) {
  const auto family = family_with("duration_s", Law::kUniform, 1.0, 9.0);
  EXPECT_EQ(draw_overrides(family, 1, 7, 0), draw_overrides(family, 1, 7, 0));
  EXPECT_NE(draw_overrides(family, 1, 7, 0), draw_overrides(family, 1, 8, 0));
  EXPECT_NE(draw_overrides(family, 1, 7, 0), draw_overrides(family, 1, 7, 1));
}

TEST(DatasetConfig, WhatWasWrittenReadsBackTheSame) {
  const TemporaryDirectory directory;
  const std::string text = write_dataset(load_dataset(kSmallDataset));
  std::ofstream(directory.path() / "again.yaml") << text;
  EXPECT_EQ(write_dataset(load_dataset(directory.path() / "again.yaml")), text);
}

TEST(DatasetConfig, SplitsMayNotShareAWorld) {
  EXPECT_THAT(
      [&] {
        load_dataset(kSmallDataset, {{"splits[1].first_seed", "101"}});
      },
      ThrowsMessage<InputError>(HasSubstr("splits[1].first_seed: expected seeds that the split train does not")));
}

TEST(DatasetConfig, AVariationOfAnUnknownKeyIsRefusedBeforeAnythingIsSimulated) {
  const DatasetConfig config = load_dataset(kSmallDataset, {{"families[0].vary[0].key", "world.num_treees"}});
  EXPECT_THAT([&] { plan_dataset(config); }, ThrowsMessage<InputError>(HasSubstr("num_treees")));
}

TEST(DatasetConfig, ATeamThatIsLargerThanTheScenariosIsRefused) {
  const DatasetConfig config = load_dataset(kSmallDataset, {{"families[0].vehicles_min", "99"}});
  EXPECT_THAT([&] { plan_dataset(config); },
              ThrowsMessage<InputError>(HasSubstr("families[0].vehicles_min: expected at most ")));
}

TEST(DatasetPlan, NumbersSequencesByFlightAndLidarAndTellsConfigurationsApart) {
  const DatasetConfig config = load_dataset(kSmallDataset);
  const DatasetPlan plan = plan_dataset(config);
  ASSERT_EQ(plan.flights.size(), 3U);
  for (std::size_t i = 0; i < plan.flights.size(); ++i) {
    EXPECT_EQ(plan.flights[i].num_sequences, 2);
    EXPECT_EQ(plan.flights[i].first_sequence, static_cast<int>(2 * i));
  }
  EXPECT_EQ(plan.flights[2].split, "valid");
  EXPECT_EQ(plan.flights[2].seed, 200U);
  EXPECT_EQ(plan_dataset(config).fingerprint, plan.fingerprint);
  const DatasetConfig faster = load_dataset(kSmallDataset, {{"families[0].flight.speed_max_mps", "2.5"}});
  EXPECT_NE(plan_dataset(faster).fingerprint, plan.fingerprint);
}

TEST(DatasetPresets, AreValidAndHaveThreeSplits) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SWIFTLET_SOURCE_DIR "/scenarios/dataset")) {
    if (entry.path().extension() != ".yaml") continue;
    SCOPED_TRACE(entry.path().string());
    const DatasetPlan plan = plan_dataset(load_dataset(entry.path()));
    std::set<std::string> splits;
    for (const Flight& flight : plan.flights) splits.insert(flight.split);
    EXPECT_EQ(splits, (std::set<std::string>{"train", "valid", "test"}));
    ++count;
  }
  EXPECT_EQ(count, 4);
}

}  // namespace
}  // namespace swiftlet::sim
