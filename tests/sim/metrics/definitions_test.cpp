// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <fstream>
#include <map>

#include "swiftlet/sim/metrics/metrics.hpp"

namespace swiftlet::sim {
namespace {

/// Two vehicles that detect, track and carry a net.
MetricTable everything_that_is_reported() {
  const Perception all = {true, true, CaptureVolume()};
  Metrics metrics({}, {"alpha", "beta"}, {all, all});
  return metrics.report();
}

TEST(MetricDefinitions, CoverEveryReportedMetricWithUnit) {
  std::map<std::string, std::string> unit_of;
  for (const MetricType& type : metric_registry()) {
    for (const MetricDefinition& metric : type.definitions) {
      EXPECT_TRUE(unit_of.emplace(metric.name, metric.unit).second) << metric.name << " is defined twice";
      EXPECT_GT(std::string(metric.definition).size(), 15U) << metric.name;
    }
  }
  const MetricTable table = everything_that_is_reported();
  for (const MetricRow& row : table.rows()) {
    ASSERT_TRUE(unit_of.contains(row.name)) << row.name;
    EXPECT_EQ(unit_of.at(row.name), row.unit) << row.name;
  }
}

TEST(MetricDefinitions, CarryTheirUnitInTheName) {
  const std::map<std::string, std::string> suffix = {
      {"m", "_m"},           {"s", "_s"},     {"m/s", "_mps"}, {"m/s^2", "_mps2"},
      {"1/min", "_per_min"}, {"rad", "_rad"}, {"B", "_bytes"},
  };
  for (const MetricType& type : metric_registry()) {
    for (const MetricDefinition& metric : type.definitions) {
      if (std::string(metric.unit).empty()) continue;
      EXPECT_TRUE(std::string(metric.name).ends_with(suffix.at(metric.unit))) << metric.name;
    }
  }
}

TEST(MetricDefinitions, ThePageIsUpToDate) {
  std::ifstream file(SWIFTLET_SOURCE_DIR "/docs/metrics.md");
  const std::string page((std::istreambuf_iterator<char>(file)), {});
  EXPECT_TRUE(page == metrics_reference())
      << "Regenerate it: build/release/swiftlet reference metrics > docs/metrics.md";
}

TEST(MetricDefinitions, OutcomesGoFromBestToWorst) {
  std::vector<std::string> words;
  for (const OutcomeDefinition& word : outcome_definitions()) words.emplace_back(word.name);
  EXPECT_THAT(words, ::testing::ElementsAre("done", "timeout", "failed", "crashed"));
}

}  // namespace
}  // namespace swiftlet::sim
