// SPDX-License-Identifier: BSD-3-Clause
#include "experiment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "parallel.hpp"
#include "swiftlet/sim/errors.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::tools {
namespace {

using testing::HasSubstr;

// Runs an experiment; no row may differ from what was published.
void expect_reproduced(const std::string& name, bool quick) {
  const TemporaryDirectory directory;
  const ExperimentType& type = experiment_type(name);
  Experiment experiment({.name = name, .directory = directory.path(), .jobs = 2, .quick = quick});
  type.run(experiment);
  EXPECT_FALSE(experiment.rows().empty());
  for (const ResultRow& row : experiment.rows()) {
    EXPECT_NE(row.verdict, Verdict::kDiffers) << row.what << ": published " << row.published << ", ours " << row.ours;
  }
  EXPECT_FALSE(experiment.files().empty());
  for (const std::string& file : experiment.files()) {
    EXPECT_GT(std::filesystem::file_size(directory.path() / file), 0u) << file;
  }
}

TEST(Experiments, VerdictsFollowTheTolerance) {
  Experiment experiment({.name = "rbl-real"});
  const std::string length = "aggressive: L [m]";  // published: 35.56
  experiment.within(length, 35.56 * 1.2, 0.25, 3);
  experiment.within(length, 35.56 * 1.3, 0.25, 3);
  experiment.at_most("c", 2.0, 1.9, 2);
  experiment.at_least("d", 2.0, 1.9, 2);
  experiment.claim("e", "holds", true);
  const auto& rows = experiment.rows();
  EXPECT_EQ(rows[0].verdict, Verdict::kReproduced);
  EXPECT_EQ(rows[1].verdict, Verdict::kDiffers);
  EXPECT_EQ(rows[2].verdict, Verdict::kDiffers);
  EXPECT_EQ(rows[3].verdict, Verdict::kReproduced);
  EXPECT_EQ(rows[4].verdict, Verdict::kReproduced);
  EXPECT_EQ(rows[0].published, "35.56");
  EXPECT_EQ(rows[2].published, "-");
  EXPECT_EQ(verdict_of(rows[0]), "reproduced");
  EXPECT_EQ(verdict_of(rows[1]), "differs");
  EXPECT_EQ(verdict_of(rows[2]), "no published figure");
  EXPECT_EQ(tolerance_of(rows[0]), "± 25 %");
  EXPECT_EQ(tolerance_of(rows[2]), "<= 1.9: missed") << "a limit of our own";
  EXPECT_EQ(tolerance_of(rows[3]), ">= 1.9: kept");
  EXPECT_EQ(tolerance_of(rows[4]), "it holds: kept");
  EXPECT_THROW(experiment.within("c", 2.0, 0.1, 2), std::logic_error) << "nothing to compare with";
}

TEST(Experiments, AQuickVersionSaysSoAndWithHowManyRuns) {
  Experiment experiment({.name = "rbl-real", .quick = true});
  EXPECT_EQ(experiment.repetitions(100, 2), 2);
  const ExperimentType type{"rbl-real", "doc", nullptr};
  const std::string text = to_markdown(type, experiment);
  EXPECT_THAT(text, HasSubstr("# rbl-real, quick version\n"));
  EXPECT_THAT(text, HasSubstr(", 2 runs a case; fewer and shorter than the full version."));
  EXPECT_THAT(to_json(type, experiment), HasSubstr("\"repetitions\": 2"));
}

TEST(Experiments, NumbersAreShort) {
  EXPECT_EQ(short_number(6.68e-4, 3), "6.68e-04");
  EXPECT_EQ(short_number(25.154, 4), "25.15");
  EXPECT_EQ(short_number(0.054, 2), "0.054");
  EXPECT_EQ(short_number(0.0, 2), "0.0");
}

TEST(Experiments, TablesEscapeBarsAndKeepTheNumber) {
  Experiment experiment({});
  experiment.row({"P(x | y)", "2", Verdict::kNotJudged, "", 2.0});
  const ExperimentType type{"name", "doc", nullptr};
  EXPECT_THAT(to_markdown(type, experiment), HasSubstr("P(x \\| y)"));
  EXPECT_THAT(to_json(type, experiment), HasSubstr("\"value\": 2.0"));
}

TEST(Experiments, CsvRowsHaveTheLengthOfTheHeader) {
  CsvTable table({"a", "b"});
  table.row({1.0, 0.1});
  EXPECT_EQ(table.text(), "a,b\n1,0.1\n");
  EXPECT_THROW(table.row({1.0}), std::logic_error);
}

TEST(Experiments, CsvNamesWithACommaAreQuoted) {
  CsvTable table({"sweep", "value"});
  table.row("noise, share of the range", {0.1});
  EXPECT_EQ(table.text(), "sweep,value\n\"noise, share of the range\",0.1\n");
}

TEST(Experiments, AnUnknownNameIsAnsweredWithTheKnownOnes) {
  try {
    experiment_type("no-such-thing");
    FAIL();
  } catch (const sim::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("uncertainty-table"));
  }
}

std::vector<sim::Scenario> short_flights() {
  std::vector<sim::Scenario> scenarios;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    sim::Scenario scenario;
    scenario.seed = seed;
    scenario.duration_s = 0.2;
    scenario.wind.gusts = true;
    scenarios.push_back(sim::validated(scenario));
  }
  return scenarios;
}

TEST(Experiments, FlightsComeBackInTheirOrderForAnyNumberOfJobs) {
  const auto hashes = [](int jobs) {
    const Experiment experiment({.jobs = jobs});
    std::vector<std::uint64_t> result;
    for (const sim::RunSummary& summary : fly(experiment, short_flights())) {
      EXPECT_EQ(summary.seed, result.size() + 1);
      result.push_back(summary.state_hash);
    }
    return result;
  };
  EXPECT_EQ(hashes(1), hashes(3));
}

TEST(Experiments, AFlightEndsEarlierWhenItsExperimentSaysSo) {
  const auto is_over = [](const sim::Simulation& simulation) { return simulation.now() >= from_seconds(0.1); };
  for (const sim::RunSummary& summary : fly(Experiment({}), short_flights(), FlightNotes{.is_over = is_over}))
    EXPECT_NEAR(summary.simulated_s, 0.1, 0.005);
}

// Ticks flown, and results.
struct Attempt {
  std::vector<double> ticks = std::vector<double>(4, 0.0), told = ticks;
  std::vector<sim::RunSummary> summaries;
};

Attempt attempt(const std::filesystem::path& directory, bool resume) {
  Attempt result;
  const Experiment experiment({.directory = directory, .resume = resume});
  const auto count = [&](std::size_t i, const sim::Simulation&) { result.told[i] = ++result.ticks[i]; };
  const auto write = [&](std::size_t i) { return std::vector<double>{result.told[i]}; };
  const auto read = [&](std::size_t i, std::span<const double> numbers) { result.told[i] = numbers[0]; };
  result.summaries = fly(experiment, short_flights(), {.after_tick = count, .write = write, .read = read});
  return result;
}

TEST(Experiments, WhatWasFinishedBeforeTheKillIsNotFlownAgain) {
  const TemporaryDirectory directory;
  const Attempt whole = attempt(directory.path(), false);
  EXPECT_THAT(whole.ticks, testing::Each(50.0));

  // The experiment is killed in the middle of the third line.
  const std::filesystem::path log = directory.path() / "flights.jsonl";
  std::ifstream in(log);
  std::string kept, line;
  for (int i = 0; i < 3 && std::getline(in, line); ++i) kept += i < 2 ? line + '\n' : line.substr(0, line.size() / 2);
  in.close();
  std::ofstream(log) << "[1, 2]\n{\"key\": 3}\n" << kept;  // preceded by invalid lines

  for (const int flown_again : {2, 0}) {  // the second time all flights are in the log
    const Attempt resumed = attempt(directory.path(), true);
    EXPECT_EQ(std::count(resumed.ticks.begin(), resumed.ticks.end(), 0.0), 4 - flown_again);
    EXPECT_EQ(resumed.told, whole.told);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(resumed.summaries[i].state_hash, whole.summaries[i].state_hash);
      EXPECT_EQ(resumed.summaries[i].outcome, whole.summaries[i].outcome);
      for (const sim::MetricRow& row : whole.summaries[i].metrics.rows()) {
        if (!row.text.empty()) continue;
        const sim::MetricRow* read = resumed.summaries[i].metrics.find(row.name, row.vehicle);
        ASSERT_NE(read, nullptr) << row.name;
        EXPECT_TRUE(read->value == row.value || (std::isnan(read->value) && std::isnan(row.value))) << row.name;
      }
    }
  }
  EXPECT_THAT(attempt(directory.path(), false).ticks, testing::Each(50.0)) << "not asked to resume";
}

TEST(Experiments, WhatFailsInOneFlightIsTold) {
  const Experiment experiment({.jobs = 2});
  EXPECT_THROW(parallel_for(experiment, 5, "steps",
                            [](std::size_t i) {
                              if (i == 3) throw std::runtime_error("three");
                            }),
               std::runtime_error);
}

TEST(Claims, UncertaintyTable) { expect_reproduced("uncertainty-table", true); }
TEST(Claims, OccupancyFilters) { expect_reproduced("occupancy-filters", false); }
TEST(Claims, ExpectedError) { expect_reproduced("expected-error", true); }
TEST(Claims, VoxelProbability) { expect_reproduced("voxel-probability", true); }

TEST(ClaimsInFull, UncertaintyTable) { expect_reproduced("uncertainty-table", false); }
TEST(ClaimsInFull, ExpectedError) { expect_reproduced("expected-error", false); }
TEST(ClaimsInFull, VoxelProbability) { expect_reproduced("voxel-probability", false); }

TEST(Claims, Communication) { expect_reproduced("communication", true); }
TEST(ClaimsInFull, Communication) { expect_reproduced("communication", false); }
TEST(ClaimsInFull, GapSuccess) { expect_reproduced("gap-success", false); }
TEST(ClaimsInFull, ForestGuidance) { expect_reproduced("forest-guidance", false); }
TEST(ClaimsInFull, NarrowGap) { expect_reproduced("narrow-gap", false); }
TEST(ClaimsInFull, GuidanceTiming) { expect_reproduced("guidance-timing", false); }

TEST(ClaimsInFull, RblCirclePrinted) { expect_reproduced("rbl-circle-printed", false); }
TEST(ClaimsInFull, RblSphere) { expect_reproduced("rbl-sphere", false); }
TEST(ClaimsInFull, RblForest) { expect_reproduced("rbl-forest", false); }
TEST(ClaimsInFull, RblReal) { expect_reproduced("rbl-real", false); }
TEST(ClaimsInFull, RblGhosts) { expect_reproduced("rbl-ghosts", false); }

TEST(ClaimsInFull, DetectionIdeal) { expect_reproduced("detection-ideal", false); }
TEST(ClaimsInFull, DetectionNoisy) { expect_reproduced("detection-noisy", false); }
TEST(ClaimsInFull, DetectionMulti) { expect_reproduced("detection-multi", false); }
TEST(ClaimsInFull, DetectionReal) { expect_reproduced("detection-real", false); }

}  // namespace
}  // namespace swiftlet::tools
