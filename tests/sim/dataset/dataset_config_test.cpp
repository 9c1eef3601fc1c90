// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/dataset/dataset_config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/timed_path.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/dataset/flight.hpp"
#include "tests/support/config_checks.hpp"
#include "tests/support/numeric_bounds.hpp"
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

TEST(DatasetDraws, CoverTheirRangesWithoutLeavingThem) {
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

TEST(DatasetDraws, AreIndependentAcrossVehicles) {
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

TEST(DatasetDraws, DependOnlyOnSeedAndAttempt) {
  const auto family = family_with("duration_s", Law::kUniform, 1.0, 9.0);
  EXPECT_EQ(draw_overrides(family, 1, 7, 0), draw_overrides(family, 1, 7, 0));
  EXPECT_NE(draw_overrides(family, 1, 7, 0), draw_overrides(family, 1, 8, 0));
  EXPECT_NE(draw_overrides(family, 1, 7, 0), draw_overrides(family, 1, 7, 1));
}

TEST(DatasetConfig, RoundTripsThroughItsFile) {
  const TemporaryDirectory directory;
  const std::string text = write_dataset(load_dataset(kSmallDataset));
  std::ofstream(directory.path() / "again.yaml") << text;
  EXPECT_EQ(write_dataset(load_dataset(directory.path() / "again.yaml")), text);
}

TEST(DatasetConfig, RefusesUnknownVariationKeyBeforeSimulating) {
  const DatasetConfig config = load_dataset(kSmallDataset, {{"families[0].vary[0].key", "world.num_treees"}});
  EXPECT_THAT([&] { plan_dataset(config); }, ThrowsMessage<InputError>(HasSubstr("num_treees")));
}

TEST(DatasetConfig, RefusesTeamLargerThanScenario) {
  const DatasetConfig config = load_dataset(kSmallDataset, {{"families[0].vehicles_min", "99"}});
  EXPECT_THAT([&] { plan_dataset(config); },
              ThrowsMessage<InputError>(HasSubstr("families[0].vehicles_min: expected at most ")));
}

TEST(DatasetPlan, NumbersSequencesAndDistinguishesConfigurations) {
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

template <class Config>
std::vector<std::string> problems_of_config(Config config) {
  return swiftlet::test::ConfigChecks(config).problems();
}

TEST(DatasetConfig, NamesAreUniqueWords) {
  DatasetConfig config;
  config.families.resize(1);
  config.families[0].scenario = "x.yaml";
  const auto takes = [&](const std::string& name) {
    config.name = name;
    return problems_of_config(config).empty();
  };
  for (const std::string name : {"a", "azAZ09_-", "Z"}) EXPECT_TRUE(takes(name)) << name;
  for (const std::string name : {"", "a.b", "a b", "/", ":"}) EXPECT_FALSE(takes(name)) << name;
  EXPECT_TRUE(takes(std::string(64, 'x')));
  EXPECT_FALSE(takes(std::string(65, 'x')));
  config.name = "fine";
  config.splits.resize(2);
  config.splits[1] = {"train", 1, 50};
  EXPECT_THAT(problems_of_config(config), ::testing::Each(HasSubstr("splits[")));
  config.splits[1].name = "valid";
  EXPECT_THAT(problems_of_config(config), ::testing::IsEmpty());
  config.families.clear();
  EXPECT_THAT(problems_of_config(config), ::testing::ElementsAre("families: expected at least one family"));
}

TEST(DatasetConfig, SplitsMayTouchButNotOverlap) {
  DatasetConfig config;
  config.families.resize(1);
  config.families[0].scenario = "x.yaml";
  const auto fine = [&](SplitConfig a, SplitConfig b) {
    config.splits = {a, b};
    return problems_of_config(config).empty();
  };
  EXPECT_TRUE(fine({"a", 3, 5}, {"b", 2, 8}));
  EXPECT_FALSE(fine({"a", 4, 5}, {"b", 2, 8}));
  EXPECT_TRUE(fine({"a", 2, 8}, {"b", 3, 5}));
  EXPECT_FALSE(fine({"a", 2, 8}, {"b", 4, 5}));
  EXPECT_FALSE(fine({"a", 2, 6}, {"b", 9, 5}));
  EXPECT_THAT(problems_of_config(config), ::testing::ElementsAre(HasSubstr("the split a does not use (6 to 7)")));
}

TEST(DatasetConfig, ValidatesVariationsByTheirLaw) {
  const struct {
    Law law;
    double min, max;
    std::vector<std::string> choices;
    bool is_fine;
  } variations[] = {{Law::kUniform, 1, 1, {}, true},     {Law::kUniform, 1, 0.999, {}, false},
                    {Law::kUniform, 0, 1, {"x"}, false}, {Law::kLogUniform, 1e-9, 1, {}, true},
                    {Law::kLogUniform, 0, 1, {}, false}, {Law::kWhole, -2, 3, {}, true},
                    {Law::kWhole, 0.5, 3, {}, false},    {Law::kWhole, 0, 3.5, {}, false},
                    {Law::kChoice, 0, 1, {"x"}, true},   {Law::kChoice, 0, 1, {}, false}};
  for (const auto& v : variations) {
    EXPECT_EQ(problems_of_config(family_with("a", v.law, v.min, v.max, v.choices).vary[0]).empty(), v.is_fine)
        << static_cast<int>(v.law) << " from " << v.min << " to " << v.max;
  }
  EXPECT_FALSE(problems_of_config(family_with("", Law::kUniform, 0, 1).vary[0]).empty());
  EXPECT_THAT(problems_of_config(FamilyConfig()), ::testing::ElementsAre("scenario: expected a scenario file"));
}

TEST(DatasetConfig, RequiresOrderedFlightBounds) {
  using Key = double FlightConfig::*;
  const std::pair<Key, Key> bounds[] = {{&FlightConfig::speed_min_mps, &FlightConfig::speed_max_mps},
                                        {&FlightConfig::height_min_m, &FlightConfig::height_max_m},
                                        {&FlightConfig::leg_min_m, &FlightConfig::leg_max_m},
                                        {&FlightConfig::partner_min_m, &FlightConfig::partner_max_m},
                                        {&FlightConfig::separation_m, &FlightConfig::partner_min_m}};
  for (const auto& [low, high] : bounds) {
    for (const double low_value : {2.9, 3.1}) {
      FlightConfig config;
      config.*low = low_value;
      config.*high = 3.0;
      EXPECT_EQ(problems_of_config(config).empty(), low_value < 3.0);
    }
  }
  ContentConfig content;
  for (const auto& [rate_hz, problems] : {std::pair(0.0, 0U), {1e-3, 0U}, {9e-4, 1U}}) {
    content.trajectory_rate_hz = rate_hz;
    EXPECT_EQ(problems_of_config(content).size(), problems) << rate_hz;
  }
}

/// A team of four above a plane, the second and the fourth with a LiDAR.
class TeamOfFour : public ::testing::Test {
 protected:
  TeamOfFour() {
    std::ofstream(folder.path() / "team.yaml") << R"(name: team
duration_s: 3
world: {type: empty, ground: true}
recorders: [{type: tum}]
snapshots: [{name: shot, times_s: [1]}]
vehicles:
  - {name: a, model: f330, agent: {type: stack, localization: ground_truth}}
  - {name: b, model: f330, sensors: [{type: lidar, name: os}], agent: {type: stack, localization: ground_truth}}
  - {name: c, model: f330, agent: {type: stack, localization: ground_truth}}
  - {name: d, model: f330, sensors: [imu, {type: lidar, name: mid}], agent: {type: stack, localization: ground_truth}}
)";
    config.name = "made";
    FamilyConfig family;
    family.scenario = (folder.path() / "team.yaml").string();
    family.vehicles_min = 2;
    family.flight.height_max_m = 6.0;
    family.flight.partner_max_m = 12.0;
    config.families = {family};
  }

  TemporaryDirectory folder;
  DatasetConfig config;
};

TEST_F(TeamOfFour, DrawsWeightedFamiliesAndTeamSizes) {
  config.families.resize(3, config.families[0]);
  const double weights[] = {1.0, 2.0, 5.0};
  for (std::size_t i = 0; i < 3; ++i) config.families[i].weight = weights[i];
  config.families[1].vehicles_min = 0;
  config.families[2].vehicles_min = 1;
  config.splits = {{"train", 1600, 1}};
  config.pictures.flights_per_split = 3;
  const DatasetPlan plan = plan_dataset(config);
  ASSERT_EQ(plan.flights.size(), 1600U);
  std::map<int, int> families;
  std::map<std::pair<int, int>, int> teams;
  int sequence = 0;
  for (std::size_t k = 0; k < plan.flights.size(); ++k) {
    const Flight& flight = plan.flights[k];
    ++families[flight.family];
    ++teams[{flight.family, flight.num_vehicles}];
    EXPECT_EQ(flight.number, static_cast<int>(k));
    EXPECT_EQ(flight.seed, 1 + k);
    EXPECT_EQ(flight.pictures, k < 3);
    EXPECT_EQ(flight.first_sequence, sequence);
    EXPECT_EQ(flight.num_sequences, flight.num_vehicles / 2) << "the second and the fourth have a LiDAR";
    sequence += flight.num_sequences;
  }
  // Five standard deviations of a count.
  for (int i = 0; i < 3; ++i) {
    const double p = weights[i] / 8.0;
    EXPECT_NEAR(families[i], 1600 * p, 5.0 * std::sqrt(1600 * p * (1.0 - p)));
  }
  const auto expect_equal_shares = [&](int family, int least) {
    const double sizes = 5.0 - least;
    for (int n = 1; n <= 4; ++n) {
      const double share = n >= least ? families[family] / sizes : 0.0;
      EXPECT_NEAR((teams[{family, n}]), share, 5.0 * std::sqrt(share)) << n << " vehicles of family " << family;
    }
  };
  expect_equal_shares(0, 2);
  expect_equal_shares(1, 4);
  expect_equal_shares(2, 1);
}

TEST_F(TeamOfFour, PreparesScenarioWithPathsAndWorld) {
  config.families[0].reflectivity_spread = 1.5;
  config.pictures.cameras.resize(2);
  config.pictures.cameras[0].name = "one";
  config.pictures.cameras[1].name = "two";
  for (CameraConfig& camera : config.pictures.cameras) camera.times_s = {1.0};
  const DatasetPlan plan = plan_dataset(config);
  Flight flight = plan.flights.at(0);
  flight.num_vehicles = 3;
  const PreparedFlight prepared = prepare_flight(plan, flight, 0);
  const Scenario& scenario = prepared.scenario;
  EXPECT_EQ(scenario.name, "made_00");
  EXPECT_EQ(scenario.seed, flight.seed);
  EXPECT_TRUE(scenario.recorders.empty());
  EXPECT_EQ(scenario.snapshots.size(), 2U) << "those of the data card alone";
  EXPECT_TRUE(scenario.metrics.stop_on_crash);
  EXPECT_FALSE(scenario.metrics.stop_when_done);
  ASSERT_EQ(scenario.vehicles.size(), 3U);
  for (const VehicleConfig& vehicle : scenario.vehicles) {
    const Module& guidance = vehicle.agent.as<StackConfig>().guidance;
    ASSERT_EQ(guidance.type, "timed_path");
    const auto& path = guidance.as<TimedPathConfig>();
    EXPECT_EQ(vehicle.start.position_m, path.points_m.front());
    EXPECT_GT(path.interval_s, 0.0);
  }
  const auto& materials = prepared.world.scene->materials;
  ASSERT_EQ(prepared.reflectivities.size(), materials.size());
  for (std::size_t i = 0; i < materials.size(); ++i) {
    EXPECT_EQ(materials[i].reflectivity, static_cast<float>(prepared.reflectivities[i]));
    EXPECT_GE(prepared.reflectivities[i], static_cast<double>(0.02F));
    EXPECT_LE(prepared.reflectivities[i], static_cast<double>(0.98F));
  }
  EXPECT_NE(prepare_flight(plan, flight, 1).reflectivities, prepared.reflectivities)
      << "another attempt draws other reflectivities";
  const World again = make_flight_world(scenario, prepared.reflectivities);
  EXPECT_EQ(again.scene->materials[0].reflectivity, materials[0].reflectivity);
  std::vector<double> too_many = prepared.reflectivities;
  too_many.push_back(0.5);
  EXPECT_THAT(
      [&] { make_flight_world(scenario, too_many); },
      ThrowsMessage<std::runtime_error>(HasSubstr("expected " + std::to_string(too_many.size()) + " materials")));
  flight.pictures = false;
  EXPECT_TRUE(prepare_flight(plan, flight, 0).scenario.snapshots.empty());
}

TEST_F(TeamOfFour, RequiresLidarAndFlyablePath) {
  std::ofstream(folder.path() / "blind.yaml") << "name: blind\nvehicles: [{name: a}]\n";
  config.families.resize(2, config.families[0]);
  config.families[1].scenario = (folder.path() / "blind.yaml").string();
  EXPECT_THAT([&] { plan_dataset(config); },
              ThrowsMessage<InputError>(HasSubstr("families[1].scenario: expected a vehicle with a lidar")));
  config.families.resize(1);
  config.families[0].vehicles_min = 4;
  EXPECT_NO_THROW(plan_dataset(config));
  config.families[0].vehicles_min = 5;
  EXPECT_THAT([&] { plan_dataset(config); }, ThrowsMessage<InputError>(HasSubstr("expected at most 4")));
  config.families[0].vehicles_min = 0;
  config.families[0].flight.border_m = 1e6;
  const DatasetPlan narrow = plan_dataset(config);
  EXPECT_THAT([&] { prepare_flight(narrow, narrow.flights.at(0), 0); },
              ThrowsMessage<NoPathFound>(HasSubstr("no free paths for 4 vehicles")));
  config.families[0].flight.indoors = FlightConfig::Indoors::kTrue;
  const DatasetPlan open = plan_dataset(config);
  EXPECT_THAT([&] { prepare_flight(open, open.flights.at(0), 0); },
              ThrowsMessage<NoPathFound>(HasSubstr("inside walls; flight.indoors: false flies outside")));
}

TEST(DatasetConfigs, AcceptNumericKeysOnlyWithinBounds) {
  std::size_t num_keys = 0;
  const auto visit = [](ConfigVisitor& v) {
    DatasetConfig fresh;
    fresh.visit(v);
  };
  EXPECT_THAT(testing::wrong_bounds(visit, num_keys), ::testing::IsEmpty());
  EXPECT_GT(num_keys, 20U);
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
