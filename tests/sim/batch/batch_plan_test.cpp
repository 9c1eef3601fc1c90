// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/batch_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "swiftlet/sim/batch/shell.hpp"
#include "swiftlet/sim/batch/slurm.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "tests/sim/batch/batch_support.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::HasSubstr;

constexpr const char* kTwoByThree =
    "variants:\n  - {name: calm, set: {wind: {mean_mps: [0, 0, 0]}}}\n  - {name: windy, set: {wind.mean_mps: [9, 0, "
    "0]}}\n"
    "sweep:\n  parameters:\n    - {key: 'vehicles[*].start.yaw_deg', values: [0, 90, 180]}\nseeds: {first: 5, count: "
    "4}\n";

TEST(BatchPlan, NumbersEpisodesByPointSeedVariant) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan(kTwoByThree);
  ASSERT_EQ(plan.num_episodes(), 24U);
  std::set<std::tuple<std::size_t, std::uint64_t, std::size_t>> all;
  for (std::uint64_t id = 0; id < 24; ++id) {
    const Episode e = plan.episode(id);
    all.insert({e.point, e.seed, e.variant});
  }
  EXPECT_EQ(all.size(), 24U);
  const Episode e = plan.episode(11);  // = 1 + 2 (1 + 4 (1)): second variant, second seed, second point
  EXPECT_EQ(e.variant, 1U);
  EXPECT_EQ(e.seed, 6U);
  EXPECT_EQ(e.point, 1U);
}

TEST(BatchPlan, AppliesAllChangesOfAnEpisode) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan(std::string(kTwoByThree) + "set: {duration_s: 0.4}\n");
  const Scenario scenario = plan.scenario_of(plan.episode(11));
  EXPECT_EQ(scenario.seed, 6U);
  EXPECT_EQ(scenario.duration_s, 0.4);
  EXPECT_EQ(scenario.wind.mean_mps.x(), 9.0);
  EXPECT_EQ(scenario.vehicles[1].start.yaw_deg, 90.0);
}

TEST(BatchPlan, EpisodeCommandReproducesTheScenario) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan(kTwoByThree);
  EXPECT_EQ(plan.command_of(plan.episode(11)),
            "swiftlet run " + folder.path("hover.yaml").string() +
                " --set 'wind.mean_mps=[9, 0, 0]' --set 'vehicles[*].start.yaw_deg=90' --seed 6");
}

TEST(BatchPlan, DistinguishesBatchFromEquallyNamedScenario) {
  const BatchFolder folder;
  folder.write("forest_patrol.yaml", "name: test\nscenario: forest_patrol\nseeds: {count: 3}\n");
  const BatchPlan plan(folder.path("forest_patrol.yaml"));
  EXPECT_EQ(plan.num_episodes(), 3U);
  EXPECT_EQ(plan.scenario_of(plan.episode(0)).name, "forest_patrol");
}

TEST(BatchPlan, GivesEachPointItsZippedSeed) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan(
      "sweep: {method: random, samples: 7, parameters: [{key: 'wind.mean_mps[0]', law: uniform}]}\nseeds: {pairing: "
      "zip, "
      "first: 3}\n");
  ASSERT_EQ(plan.num_episodes(), 7U);
  for (std::uint64_t id = 0; id < 7; ++id) {
    EXPECT_EQ(plan.episode(id).seed, 3 + id);
    EXPECT_EQ(plan.episode(id).point, id);
  }
  EXPECT_THROW(
      folder.plan(
          "sweep: {parameters: [{key: 'wind.mean_mps[0]', values: [1, 2]}]}\nseeds: {pairing: zip, list: [1, 2, 3]}\n"),
      InputError);
}

TEST(BatchPlan, FindsMistakesBeforeAnyFlight) {
  const BatchFolder folder;
  const std::pair<const char*, const char*> mistakes[] = {
      {"sede: 3\n", "batch.yaml:3:1"},
      {"set:\n  wind:\n    meen_mps: 3\n", "batch.yaml:5:5: set.wind.meen_mps: "},
      {"set:\n  duration_s: 2\n  wnd.x: 3\n", "batch.yaml:5:3: set.wnd.x: "},
      {"variants:\n  - name: a\n  - {name: b, set: {'vehicles[0].start.yaw': 1}}\n",
       "batch.yaml:5:21: variants[1].set.vehicles[0].start.yaw: "},
      {"variants: [{name: a, scenario: hovver}]\n", "hovver"},
      {"variants: [{name: a}, {name: a}]\n", "taken"},
      {"sweep:\n  parameters:\n    - {key: duration_s, values: [1]}\n    - {key: wnd, values: [1]}\n",
       "batch.yaml:6:13: sweep.parameters[1].key: wnd: "},
      {"sweep: {parameters: [{key: duration_s, values: [1, -2]}]}\n", "duration_s"},
      {"sweep: {parameters: [{key: world, values: [empty, forrest, field]}]}\n", "forrest"},
      {"sweep: {parameters: [{key: duration_s}]}\n", "values"},
      {"seeds: {list: [1, x]}\n", "seeds.list[1]"},
      {"seeds: {list: [1, 1]}\n", "once"},
  };
  for (const auto& [text, message] : mistakes) {
    try {
      folder.plan(text);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(message));
    }
  }
  folder.write("batch.yaml", "name: test\nscenario: hover\n");
  EXPECT_THROW(BatchPlan(folder.path("batch.yaml"), {{"set.wnd", "3"}}), InputError);
}

TEST(BatchPlan, FingerprintFollowsMeaningOnly) {
  const BatchFolder folder;
  const std::string original = folder.plan(kTwoByThree).fingerprint();
  EXPECT_EQ(
      folder
          .plan(std::string("# a comment\ntimeout_s: 5\nthreads: 2\nreport: {worst_by: path_length_m}\n") + kTwoByThree)
          .fingerprint(),
      original);
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = kTwoByThree;
    text.replace(text.find(from), from.size(), to);
    return folder.plan(text).fingerprint();
  };
  EXPECT_NE(changed("count: 4", "count: 5"), original);
  EXPECT_NE(changed("180", "181"), original);
  EXPECT_NE(changed("windy", "stormy"), original);
  EXPECT_NE(changed("[9, 0, 0]", "[8, 0, 0]"), original);
  // A change of the scenario that writes the same thing otherwise is none.
  folder.write(
      "hover.yaml",
      "duration_s: 200 ms\nname: hover\nworld: empty\nwind: {mean_mps: [1, 0, 0], gusts: true}\nseed: 77\nvehicles:\n"
      "  - {start: {position_m: [0, 0, 5]}, agent: {localization: ground_truth}, name: a}\n"
      "  - {name: b, start: {position_m: [5, 0, 5]}, agent: {localization: {type: ground_truth}}}\n");
  EXPECT_EQ(folder.plan(kTwoByThree).fingerprint(), original);
  folder.write("hover.yaml",
               "name: hover\nduration_s: 0.2\nworld: {type: empty}\nvehicles: [{name: a}, {name: b, start: "
               "{position_m: [5, 0, 5]}}]\n");
  EXPECT_NE(folder.plan(kTwoByThree).fingerprint(), original);
}

TEST(BatchPlan, FingerprintIncludesModelsOfTheSweep) {
  const BatchFolder folder;
  const std::string text = "sweep: {parameters: [{key: 'vehicles[0].model', values: [x500, mine.yaml]}]}\n";
  // Files in changes are looked for where the program runs.
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  folder.write("mine.yaml", "base: " SWIFTLET_SOURCE_DIR "/assets/vehicles/x500.yaml\nairframe: {mass_kg: 2.0}\n");
  const std::string original = folder.plan(text).fingerprint();
  folder.write("mine.yaml", "base: " SWIFTLET_SOURCE_DIR "/assets/vehicles/x500.yaml\nairframe: {mass_kg: 2.1}\n");
  EXPECT_NE(folder.plan(text).fingerprint(), original);
  std::filesystem::current_path(before);
}

TEST(BatchPlan, PartitionsEpisodesIntoShardsByWorld) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan(kTwoByThree);
  for (const int count : {1, 2, 5, 24, 30}) {
    std::multiset<std::uint64_t> all;
    for (int i = 0; i < count; ++i) {
      const auto part = plan.episodes_of({i, count, ""});
      all.insert(part.begin(), part.end());
    }
    EXPECT_EQ(all.size(), 24U);
    EXPECT_EQ(std::set<std::uint64_t>(all.begin(), all.end()).size(), 24U) << count;
  }
  // Four seeds, hence four worlds, in four shards.
  for (int i = 0; i < 4; ++i) {
    std::set<std::uint64_t> seeds;
    for (const std::uint64_t id : plan.episodes_of({i, 4, ""})) seeds.insert(plan.episode(id).seed);
    EXPECT_EQ(seeds.size(), 1U);
  }
}

TEST(BatchPlan, GroupsEpisodesThatShareAWorld) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan(kTwoByThree);
  EXPECT_EQ(plan.group_of(plan.episode(0)), plan.group_of(plan.episode(1)));  // variants
  EXPECT_EQ(plan.group_of(plan.episode(0)), plan.group_of(plan.episode(8)));  // a yaw is none of the world's business
  EXPECT_NE(plan.group_of(plan.episode(0)), plan.group_of(plan.episode(2)));  // another seed
  const BatchPlan fixed = folder.plan(std::string(kTwoByThree) + "set: {world_seed: 4}\n");
  EXPECT_EQ(fixed.group_of(fixed.episode(0)), fixed.group_of(fixed.episode(2)));
}

TEST(Shell, QuotesSpecialCharacters) {
  for (const char* plain : {"run-09.yaml", "/a_b/Az.Z0", "x=1,2:3@4%5+6"}) EXPECT_EQ(in_shell_quotes(plain), plain);
  EXPECT_EQ(in_shell_quotes("a b"), "'a b'");
  EXPECT_EQ(in_shell_quotes(""), "''");
  EXPECT_EQ(in_shell_quotes("it's"), "'it'\\''s'");
  EXPECT_EQ(in_shell_quotes("$(id)"), "'$(id)'");
}

}  // namespace
}  // namespace swiftlet::sim
