// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/yaml_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <sstream>

#include "swiftlet/sim/scenario/document.hpp"
#include "tests/sim/scenario/example_config.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

FleetConfig read_fleet(const std::string& text, const Overrides& overrides = {}) {
  FleetConfig fleet;
  const MemoryFiles files = example_files();
  read_config_text(
      text, "/in/fleet.yaml", [&](ConfigVisitor& v) { fleet.visit(v); }, overrides, files);
  return fleet;
}

/// The message of the InputError that reading ends in, without the folder.
std::string fleet_error(const std::string& text, const Overrides& overrides = {}) {
  try {
    read_fleet(text, overrides);
  } catch (const InputError& problem) {
    std::string message = problem.what();
    for (std::size_t at; (at = message.find("/in/fleet.yaml")) != std::string::npos;) message.erase(at, 4);
    return message;
  }
  return "no error";
}

// --- values ---

TEST(YamlReader, KeepsDefaultsOfMissingKeys) {
  const FleetConfig fleet = read_fleet("seed: 7\nboats: [{}]\n");
  EXPECT_EQ(fleet.seed, 7u);
  EXPECT_EQ(fleet.title, "fleet");
  ASSERT_EQ(fleet.boats.size(), 1u);
  EXPECT_EQ(fleet.boats[0].rate_hz, 10.0);
}

TEST(YamlReader, EveryKindOfValueIsRead) {
  const FleetConfig fleet = read_fleet(
      "racing: true\nseed: 18446744073709551615\ntitle: \"a: b\"\nsky: cloudy\nchart: chart.csv\nlow: -1e-3\n"
      "size_m: [1, 2.5]\ntimes_s: [0, 1.5]\ntags: [red, 12]\nbuoys_m: [[1, 2, 3], [4, 5, 6]]\n"
      "boats:\n  - width_px: 800\n    position_m: [0, 0, -2]\n    noise: {drop_probability: 0.5}\n"
      "    drive: {type: sail, area_m2: 3}\n    crew:\n      - {type: pilot, drive: {type: sail}}\n      - sail\n");
  EXPECT_TRUE(fleet.racing);
  EXPECT_EQ(fleet.seed, 18446744073709551615u);
  EXPECT_EQ(fleet.title, "a: b");
  EXPECT_EQ(fleet.sky, "cloudy");
  EXPECT_EQ(fleet.chart, "/in/chart.csv");
  EXPECT_EQ(fleet.low, -1e-3);
  EXPECT_EQ(fleet.size_m, Eigen::Vector2d(1.0, 2.5));
  EXPECT_EQ(fleet.times_s, (std::vector<double>{0.0, 1.5}));
  EXPECT_EQ(fleet.tags, (std::vector<std::string>{"red", "12"}));
  ASSERT_EQ(fleet.buoys_m.size(), 2u);
  EXPECT_EQ(fleet.buoys_m[1], Eigen::Vector3d(4, 5, 6));
  ASSERT_EQ(fleet.boats.size(), 1u);
  EXPECT_EQ(fleet.boats[0].width_px, 800);
  EXPECT_EQ(fleet.boats[0].noise.drop_probability, 0.5);
  EXPECT_EQ(fleet.boats[0].drive.as<SailConfig>().area_m2, 3.0);
  ASSERT_EQ(fleet.boats[0].crew.size(), 2u);
  EXPECT_EQ(fleet.boats[0].crew[0].as<PilotConfig>().drive.type, "sail");
  EXPECT_EQ(fleet.boats[0].crew[1].type, "sail");
}

TEST(YamlReader, ReplacesDefaultListsEntirely) {
  FleetConfig fleet;
  fleet.boats[0].rate_hz = 99.0;
  read_config_text(
      "boats: [{name: a}]", "x.yaml", [&](ConfigVisitor& v) { fleet.visit(v); }, {}, example_files());
  EXPECT_EQ(fleet.boats[0].rate_hz, 10.0);
}

TEST(YamlReader, ConvertsUnitsOfTheSameKind) {
  const auto boat = [](const std::string& line) { return read_fleet("boats: [{" + line + "}]").boats.at(0); };
  EXPECT_EQ(boat("noise: {sigma_range_m: 20 cm}").noise.sigma_range_m, 0.2);
  EXPECT_EQ(boat("noise: {sigma_range_m: 35mm}").noise.sigma_range_m, 0.035);
  EXPECT_EQ(boat("rate_hz: 2 kHz").rate_hz, 2000.0);
  EXPECT_EQ(boat("tilt_deg: 90 deg").tilt_deg, 90.0);
  EXPECT_DOUBLE_EQ(boat("tilt_deg: 0.5 rad").tilt_deg, 0.5 * 180.0 / std::numbers::pi);
  EXPECT_DOUBLE_EQ(boat("speed_mps: 18 km/h").speed_mps, 5.0);
  EXPECT_EQ(boat("width_px: 800 px").width_px, 800);
  EXPECT_EQ(boat("position_m: [1 km, 20 cm, 3]").position_m, Eigen::Vector3d(1000.0, 0.2, 3.0));
  EXPECT_EQ(read_fleet("times_s: [300 ms, 2 min, 1 h]").times_s, (std::vector<double>{0.3, 120.0, 3600.0}));
}

TEST(YamlReader, RefusesUnitsOfAnotherKind) {
  EXPECT_EQ(fleet_error("boats:\n  - noise: {sigma_range_m: 20 deg}\n"),
            "fleet.yaml:2:28: boats[0].noise.sigma_range_m: expected a length in m, found \"20 deg\"");
  EXPECT_EQ(fleet_error("boats: [{drag_N_per_mps: 2 N}]"),
            "fleet.yaml:1:26: boats[0].drag_N_per_mps: expected a number >= 0, found \"2 N\"");
  EXPECT_THAT(fleet_error("boats: [{rate_hz: 2 hurts}]"), HasSubstr("expected a frequency in Hz, found \"2 hurts\""));
  EXPECT_THAT(fleet_error("low: 2 m"), HasSubstr("low: expected a number, found \"2 m\""));
}

// --- errors ---

TEST(YamlReader, DescribesMistakesWithPlaceAndExpectation) {
  const std::pair<const char*, const char*> mistakes[] = {
      {"seed: 1\nboats:\n  - name: a\n  - rate_hz: ten\n",
       "4:14: boats[1].rate_hz: expected a number > 0, found \"ten\""},
      {"boats: [{speed_mps: 10}]", "1:21: boats[0].speed_mps: expected a number in (-10, 10), found \"10\""},
      {"boats: [{width_px: 5}]", "1:20: boats[0].width_px: expected a whole number in [16, 4096], found \"5\""},
      {"sky: clowdy",
       "1:6: sky: expected one of \"clear\", \"cloudy\", \"overcast\", found \"clowdy\"; did you mean \"cloudy\"?"},
      {"racing: yes", "1:9: racing: expected true or false, found \"yes\"; did you mean \"true\"?"},
      {"boats: 3", "1:8: boats: expected a list, found \"3\""},
      {"boats: [7]", "1:9: boats[0]: expected a map of keys, found \"7\""},
      {"size_m: [1, 2, 3]", "1:9: size_m: expected a list of 2 numbers, found a list of 3 values"},
      {"size_m: [1, -2]", "1:13: size_m[1]: expected a number > 0, found \"-2\""},
      {"buoys_m: [[1, 2]]", "1:11: buoys_m[0]: expected a list of 3 numbers, found a list of 2 values"},
      {"title:\nseed: 1", "1:1: title: expected a text, found nothing"},
      {"title: {a: 1}", "1:8: title: expected a text, found a map"},
      {"seed: -1", "1:7: seed: expected a whole number in [0, 18446744073709551615], found \"-1\""},
      {"low: \"1\"", "1:6: low: expected a number, found the quoted text \"1\""},
  };
  for (const auto& [text, message] : mistakes) EXPECT_EQ(fleet_error(text), std::string("fleet.yaml:") + message);
}

TEST(YamlReader, SuggestsCorrectionsForUnknownKeys) {
  EXPECT_EQ(fleet_error("boats:\n  - noise:\n      sigma_rage_m: 1\n"),
            "fleet.yaml:3:7: boats[0].noise.sigma_rage_m: expected a known key, found \"sigma_rage_m\"; "
            "did you mean \"sigma_range_m\"?");
  EXPECT_EQ(
      fleet_error("boats: [{noise: {xyz: 1}}]"),
      "fleet.yaml:1:18: boats[0].noise.xyz: expected one of \"sigma_range_m\", \"drop_probability\", found \"xyz\"");
  EXPECT_THAT(fleet_error("boats: [{rate: 1}]"), HasSubstr("did you mean \"rate_hz\"?"));
  EXPECT_THAT(fleet_error("boats: [{tilt_rad: 1}]"), HasSubstr("did you mean \"tilt_deg\"?"));
  EXPECT_THAT(fleet_error("Seed: 1"), HasSubstr("did you mean \"seed\"?"));
  EXPECT_THAT(
      fleet_error("boats: [{drive: {type: engin}}]"),
      HasSubstr(
          "boats[0].drive.type: expected one of \"engine\", \"sail\", found \"engin\"; did you mean \"engine\"?"));
  EXPECT_THAT(fleet_error("boats: [{drive: {type: sail, power_kW: 1}}]"),
              HasSubstr("boats[0].drive.power_kW: expected one of"));
  EXPECT_THAT(fleet_error("boats: [{crew: [{name: x}]}]"),
              HasSubstr("boats[0].crew[0].type: expected one of \"pilot\", \"sail\", found nothing"));
}

TEST(YamlReader, RefusesInvalidNumbers) {
  for (const char* text : {".nan", ".inf", "-.inf", "nan", "inf", "1e999", "1,5", "0x10", "--1", "+-1", "1_000",
                           "1.2.3", "e5", "", "~", "[]", "true", "1 2", "- 1"}) {
    EXPECT_THAT(fleet_error(std::string("low: ") + text), StartsWith("fleet.yaml")) << text;
  }
  for (const char* text : {"1.5", "1e10", "99999999999", "x"}) {
    EXPECT_THAT(fleet_error(std::string("boats: [{width_px: ") + text + "}]"), HasSubstr("expected a whole number"))
        << text;
  }
  for (const char* text : {"18446744073709551616", "1.0", "+1", "1 m", "0x1"}) {
    EXPECT_THAT(fleet_error(std::string("seed: ") + text), HasSubstr("expected a whole number")) << text;
  }
  EXPECT_EQ(read_fleet("low: +0.5").low, 0.5);
  EXPECT_EQ(read_fleet("low: .5").low, 0.5);
}

TEST(YamlReader, ReportsAllMistakesInTextOrder) {
  const std::string message = fleet_error("sead: 1\nlow: x\nboats:\n  - rate_hz: 0\n    nam: a\n");
  std::istringstream lines(message);
  std::vector<std::string> places;
  for (std::string line; std::getline(lines, line);) places.push_back(line.substr(0, line.find(": ")));
  EXPECT_EQ(places,
            (std::vector<std::string>{"fleet.yaml:1:1", "fleet.yaml:2:6", "fleet.yaml:4:14", "fleet.yaml:5:5"}));

  std::string many;
  for (int i = 0; i < 100; ++i) many += "unknown" + std::to_string(i) + ": 1\n";
  const std::string bounded = fleet_error(many);
  EXPECT_EQ(std::count(bounded.begin(), bounded.end(), '\n'), 19);
}

TEST(YamlReader, ReportsContradictionsAtTheirKey) {
  EXPECT_EQ(fleet_error("low: 2\n"), "fleet.yaml:1:6: low: expected less than high, found \"2\"");
  EXPECT_EQ(fleet_error("high: -1\n"), "fleet.yaml:1:1: low: expected less than high, found \"0\" by default");
  EXPECT_EQ(fleet_error("boats:\n  - name: a\n  - name: a\n"),
            "fleet.yaml:3:11: boats[1].name: expected another name than the boat before, found \"a\"");
}

TEST(YamlReader, ShortensOddTextToOneLine) {
  const std::string message = fleet_error("low: " + std::string(1000, 'x'));
  EXPECT_LT(message.size(), 200u);
  EXPECT_THAT(message, HasSubstr("xxx...\""));
  const std::string odd = fleet_error("\"a\\nb\\tc\\x01\": 1");
  EXPECT_EQ(std::count(odd.begin(), odd.end(), '\n'), 0) << odd;
  EXPECT_EQ(odd.find('\x01'), std::string::npos);
  EXPECT_THAT(fleet_error("low: " + std::string(70, 'x') + "\xC3\xA9"), HasSubstr("..."));
}

// --- texts that are not configurations ---

TEST(YamlReader, RefusesDuplicateKeysAtAnyDepth) {
  EXPECT_EQ(fleet_error("seed: 1\nlow: 0\nseed: 2\n"),
            "fleet.yaml:3:1: expected each key once, found \"seed\" again (first in line 1)");
  EXPECT_THAT(fleet_error("boats: [{name: a, name: a}]"), HasSubstr("expected each key once, found \"name\""));
  EXPECT_THAT(fleet_error("unknown: [{a: 1, \"a\": 2}]"), HasSubstr("expected each key once"));
}

TEST(YamlReader, RefusesAllButOneUtf8Map) {
  const std::pair<std::string, const char*> refused[] = {
      {"", "fleet.yaml: expected a map of keys, found an empty text"},
      {"# only a comment\n", "found an empty text"},
      {"- 1\n- 2\n", "expected a map of keys, found a list of 2 values"},
      {"hello", "expected a map of keys, found \"hello\""},
      {"seed: 1\n---\nseed: 2\n", "expected one document"},
      {"boats:\n\t- name: a\n", "fleet.yaml:2:1: expected spaces as indentation, found a tab"},
      {"seed: 1\n \xFF\n", "fleet.yaml:2:2: expected UTF-8 text, found the byte 0xff"},
      {{"a\0b", 3}, "control character 0x00"},
      {"\xFF\xFE" + std::string("s\0e\0", 4), "expected UTF-8"},
      {"title: \"\\N\"", "expected UTF-8 text, found an escape sequence"},
      {"title: [1, 2\n", "fleet.yaml:2:1: expected YAML, found a mistake"},
      {"title: !!str x", "found the tag"},
      {"? [a]\n: 1\n", "expected a word as key"},
  };
  for (const auto& [text, message] : refused) EXPECT_THAT(fleet_error(text), HasSubstr(message));
  EXPECT_EQ(fleet_error("title: \xE2\x82\xAC"), "no error");
}

// --- merge keys of YAML 1.1 ---

TEST(MergeKeys, FillMissingKeysPreferringEarlierMaps) {
  const FleetConfig fleet = read_fleet(
      "boats:\n"
      "  - &slow {name: a, speed_mps: 1, noise: {sigma_range_m: 0.5}}\n"
      "  - &fast {name: b, speed_mps: 9, rate_hz: 20}\n"
      "  - {<<: *slow, name: c}\n"
      "  - <<: [*slow, *fast]\n"
      "    name: d\n"
      "    noise: {drop_probability: 0.25}\n"
      "  - {name: e, <<: {speed_mps: 3}}\n");
  ASSERT_EQ(fleet.boats.size(), 5u);
  EXPECT_EQ(fleet.boats[2].name, "c") << "a key of one's own wins, wherever it stands";
  EXPECT_EQ(fleet.boats[2].speed_mps, 1.0);
  EXPECT_EQ(fleet.boats[2].noise.sigma_range_m, 0.5);
  EXPECT_EQ(fleet.boats[3].speed_mps, 1.0) << "the first of several maps with the key wins";
  EXPECT_EQ(fleet.boats[3].rate_hz, 20.0);
  EXPECT_EQ(fleet.boats[3].noise.sigma_range_m, NoiseConfig().sigma_range_m) << "maps within are not merged";
  EXPECT_EQ(fleet.boats[4].speed_mps, 3.0);
  // An anchor includes what was merged into its map, and elements of a merged list can be changed.
  EXPECT_EQ(read_fleet("boats: [&a {rate_hz: 3}, &b {<<: *a, name: b}, {<<: *b, name: c}]").boats[2].rate_hz, 3.0);
  EXPECT_EQ(read_fleet("{<<: {tags: [a, b]}, \"tags[1]\": c}").tags, (std::vector<std::string>{"a", "c"}));
}

TEST(MergeKeys, ReportMistakesAtTheMergedText) {
  const std::string boats = "boats:\n  - &one {name: a, sped_mps: 1}\n  - {<<: *one, name: b}\n";
  EXPECT_EQ(fleet_error(boats),
            "fleet.yaml:2:20: boats[0].sped_mps: expected a known key, found \"sped_mps\"; did you mean "
            "\"speed_mps\"?");
  EXPECT_EQ(fleet_error("<<: &x 5"), "fleet.yaml:1:5: <<: expected a map or a list of maps, found \"5\"");
  EXPECT_THAT(fleet_error("<<:\n"), HasSubstr("<<: expected a map or a list of maps, found nothing"));
  EXPECT_THAT(fleet_error("<<: [{seed: 1}, 5]"), HasSubstr("<<: expected a map or a list of maps, found \"5\""));
  EXPECT_THAT(fleet_error("<<: {seed: 1}\n<<: {title: a}\n"), HasSubstr("expected each key once, found \"<<\" again"));
  EXPECT_THAT(fleet_error("\"<<\": {seed: 1}"), HasSubstr("found \"<<\"")) << "a word in quotes is a word";
}

TEST(MergeKeys, AreChangedByOverrides) {
  const std::string boats = "boats: [&a {name: a, rate_hz: 3}, {<<: *a, name: b}]\n";
  const FleetConfig fleet = read_fleet(boats, {{"boats[b].rate_hz", "8"}});
  EXPECT_EQ(fleet.boats[0].rate_hz, 3.0);
  EXPECT_EQ(fleet.boats[1].rate_hz, 8.0);
}

TEST(MergeKeys, CountAgainstTheBounds) {
  std::ostringstream bomb;
  bomb << "a0: &a0 {x: [1, 2, 3, 4, 5, 6, 7, 8, 9]}\n";
  for (int i = 1; i < 12; ++i) {
    bomb << "a" << i << ": &a" << i << " {";
    for (int k = 0; k < 9; ++k) bomb << "k" << k << ": {<<: *a" << i - 1 << "}, ";
    bomb << "}\n";
  }
  EXPECT_THAT(fleet_error(bomb.str()), HasSubstr("aliases counted"));
  const auto half = [](const std::string& anchor, int first) {
    std::string text = anchor + ": &" + anchor + " {";
    for (int i = first; i < first + 3000; ++i) text += "k" + std::to_string(i) + ": 1, ";
    return text + "}\n";
  };
  EXPECT_THAT(fleet_error(half("a", 0) + half("b", 3000) + "c: {<<: [*a, *b]}\n"), HasSubstr("at most 4096 keys"));
}

TEST(YamlReader, AcceptsBomAndWindowsLineEnds) {
  EXPECT_EQ(read_fleet("\xEF\xBB\xBFseed: 3\r\ntitle: x\r\n").title, "x");
}

TEST(YamlReader, AliasesWorkWithinBounds) {
  const FleetConfig fleet = read_fleet("boats:\n  - &first {rate_hz: 3}\n  - *first\n");
  ASSERT_EQ(fleet.boats.size(), 2u);
  EXPECT_EQ(fleet.boats[1].rate_hz, 3.0);
  EXPECT_THAT(fleet_error("title: *nothing"), HasSubstr("expected YAML"));
  EXPECT_THAT(fleet_error("title: &x [*x]"), HasSubstr("one of itself"));

  std::ostringstream bomb;
  bomb << "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    bomb << "a" << i << ": &a" << i << " [*a" << i - 1;
    for (int k = 0; k < 8; ++k) bomb << ", *a" << i - 1;
    bomb << "]\n";
  }
  EXPECT_THAT(fleet_error(bomb.str()), HasSubstr("aliases counted"));
}

TEST(YamlReader, DeepOrLargeInputEndsSoon) {
  EXPECT_THAT(fleet_error(std::string(100000, '[')), StartsWith("fleet.yaml:1:1: "));
  EXPECT_THAT(fleet_error("a: " + std::string(1000, '[') + std::string(1000, ']')), HasSubstr("64 levels"));
  std::string steps;
  for (int i = 0; i < 100; ++i) steps += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  EXPECT_THAT(fleet_error(steps), HasSubstr("64 levels"));
  EXPECT_THAT(fleet_error("title: " + std::string(kMaxFileBytes, 'x')), HasSubstr("expected at most 16 MB"));
  std::string list = "boats: [";
  for (int i = 0; i < 110000; ++i) list += "x,";
  EXPECT_THAT(fleet_error(list + "x]"), HasSubstr("at most 100000 values"));
}

TEST(YamlReader, ChangesThatMultiplyAreBounded) {
  std::string text = "tags: [";
  for (int i = 0; i < 50000; ++i) text += "a,";
  text += "a]\ntags[*]: [";
  for (int i = 0; i < 50000; ++i) text += "b,";
  EXPECT_THAT(fleet_error(text + "b]"), HasSubstr("changed values, found more"));
}

// --- overlays ---

TEST(Overlay, MergesMapsAndReplacesAnythingElse) {
  const FleetConfig fleet = read_fleet("base: calm.yaml\nseed: 9\n");
  EXPECT_EQ(fleet.title, "calm");
  EXPECT_EQ(fleet.seed, 9u);
  EXPECT_EQ(fleet.boats.size(), 2u);
  EXPECT_EQ(read_fleet("base: calm.yaml\nboats: []\n").boats.size(), 0u);
}

TEST(Overlay, FindsNestedBasesInScenarioFolder) {
  const FleetConfig fleet = read_fleet("base: storm\n");
  EXPECT_EQ(fleet.sky, "overcast");
  EXPECT_EQ(fleet.title, "calm");
}

TEST(Overlay, ChangesElementsByIndexOrName) {
  const FleetConfig fleet =
      read_fleet("base: calm.yaml\nboats[*]: {tilt_deg: 4}\nboats[0]: {rate_hz: 6}\nboats[second]: {rate_hz: 8}\n");
  ASSERT_EQ(fleet.boats.size(), 2u);
  EXPECT_EQ(fleet.boats[0].tilt_deg, 4.0);
  EXPECT_EQ(fleet.boats[1].tilt_deg, 4.0);
  EXPECT_EQ(fleet.boats[0].rate_hz, 6.0);
  EXPECT_EQ(fleet.boats[0].name, "first");
  EXPECT_EQ(fleet.boats[1].rate_hz, 8.0);
  EXPECT_EQ(fleet_error("base: calm.yaml\nboats[2]: {rate_hz: 6}\n"),
            "fleet.yaml:2:1: boats[2]: expected an index below 2, the name of an element or *, found \"2\"");
  EXPECT_THAT(fleet_error("base: calm.yaml\ntitle[0]: x\n"),
              HasSubstr("expected a list whose elements can be changed"));
}

TEST(Overlay, ChangesElementsByCommonNamePrefix) {
  const std::string boats = "boats: [{name: red1}, {name: blue1, rate_hz: 3}, {name: red2}, {name: infrared}]\n";
  const FleetConfig fleet = read_fleet(boats, {{"boats[red*].rate_hz", "7"}, {"boats[red2*].tilt_deg", "2"}});
  ASSERT_EQ(fleet.boats.size(), 4u);
  EXPECT_EQ(fleet.boats[0].rate_hz, 7.0);
  EXPECT_EQ(fleet.boats[1].rate_hz, 3.0);
  EXPECT_EQ(fleet.boats[2].rate_hz, 7.0);
  EXPECT_NE(fleet.boats[3].rate_hz, 7.0);  // only the end of the name matches
  EXPECT_EQ(fleet.boats[2].tilt_deg, 2.0);
  EXPECT_NE(fleet.boats[0].tilt_deg, 2.0);
  EXPECT_THAT(fleet_error("base: calm.yaml\nboats[green*]: {rate_hz: 7}\n"),
              HasSubstr("boats[green*]: expected an index below 2, the name of an element or *, found \"green*\""));
}

TEST(Overlay, AnotherTypeStartsAfresh) {
  const std::string base = "boats: [{drive: {type: engine, cylinders: 2}, crew: [sail]}]\n";
  EXPECT_EQ(read_fleet(base, {{"boats[0].drive.type", "sail"}}).boats[0].drive.type, "sail");
  EXPECT_EQ(read_fleet(base, {{"boats[0].drive.power_kW", "3"}}).boats[0].drive.as<EngineConfig>().cylinders, 2);
  // The short form of a module takes further keys as well.
  EXPECT_EQ(read_fleet(base, {{"boats[0].crew[0].area_m2", "3"}}).boats[0].crew[0].as<SailConfig>().area_m2, 3.0);
}

TEST(Overlay, ReportsTheChainOfACycle) {
  EXPECT_EQ(fleet_error("base: circle.yaml"),
            "/in/circle.yaml:1:7: base: expected a chain of files that ends, found fleet.yaml -> /in/circle.yaml -> "
            "/in/circle.yaml");
}

TEST(Overlay, ReportsMissingOrBrokenBases) {
  EXPECT_EQ(fleet_error("base: clam.yaml"),
            "fleet.yaml:1:7: base: expected the name of a file, found \"clam.yaml\", which does not exist; did you "
            "mean \"calm.yaml\"?");
  // A file of another kind is not quoted, whatever it holds.
  EXPECT_EQ(fleet_error("base: chart.csv"),
            "fleet.yaml:1:7: base: expected the name of a file, found \"chart.csv\", which is not named .yaml or .yml");
  EXPECT_THAT(fleet_error("base: broken.yaml"), StartsWith("/in/broken.yaml:"));
  EXPECT_THAT(fleet_error("base: [a]"), HasSubstr("base: expected the name of a file, found a list of 1 value"));
}

TEST(Overrides, TheLastOneWins) { EXPECT_EQ(read_fleet("seed: 1", {{"seed", "2"}, {"seed", "3"}}).seed, 3u); }

TEST(Overrides, ReachListsAssetsAndDefaults) {
  const FleetConfig fleet =
      read_fleet("base: calm.yaml", {{"boats[1].noise.sigma_range_m", "20 cm"}, {"boats[*].position_m", "[1, 1, 1]"}});
  EXPECT_EQ(fleet.boats[1].noise.sigma_range_m, 0.2);
  EXPECT_EQ(fleet.boats[0].position_m, Eigen::Vector3d(1, 1, 1));
  // A list that only the defaults have.
  EXPECT_EQ(read_fleet("seed: 1", {{"boats[1].rate_hz", "4"}}).boats[1].rate_hz, 4.0);
  EXPECT_EQ(read_fleet("seed: 1", {{"boats[1].rate_hz", "4"}}).boats[0].rate_hz, 10.0);
  EXPECT_EQ(read_fleet("seed: 1", {{"boats[0].position_m[2]", "7"}}).boats[0].position_m, Eigen::Vector3d(1, 2, 7));
  EXPECT_EQ(read_fleet("seed: 1", {{"times_s[0]", "0.5"}}).times_s, (std::vector<double>{0.5, 2, 3}));
  // A list that only the asset has.
  const FleetConfig boats = read_fleet("boats: [{model: dinghy}]", {{"boats[0].crew[bob].reaction_s", "2"}});
  EXPECT_EQ(boats.boats[0].crew[1].as<PilotConfig>().reaction_s, 2.0);
}

TEST(Overrides, MistakesNameTheOption) {
  EXPECT_EQ(fleet_error("seed: 1", {{"boats[0].rat_hz", "4"}}),
            "--set boats[0].rat_hz: expected a known key, found \"rat_hz\"; did you mean \"rate_hz\"?");
  EXPECT_EQ(fleet_error("seed: 1", {{"seed", "x"}}),
            "--set seed: expected a whole number in [0, 18446744073709551615], found \"x\"");
  EXPECT_EQ(fleet_error("seed: 1", {{"seed.foo", "x"}}),
            "--set seed.foo: seed: expected a whole number in [0, 18446744073709551615], found a map");
  EXPECT_THAT(fleet_error("seed: 1", {{"boats[5].rate_hz", "4"}}), HasSubstr("boats[5]: expected an index below 2"));
  EXPECT_THAT(fleet_error("base: calm.yaml", {{"boats[5].rate_hz", "4"}}),
              HasSubstr("boats[5]: expected an index below 2"));
  for (const char* path : {"", ".", "a.", ".a", "a..b", "a[", "a[]", "[0]", "a[0]b", "a[0]."}) {
    EXPECT_THAT(fleet_error("seed: 1", {{path, "4"}}), StartsWith("--set: expected a path such as")) << path;
  }
  EXPECT_THAT(fleet_error("seed: 1", {{"title", "[1"}}),
              HasSubstr("--set title:1:1: expected a word as key, found a list (or is a bracket left open?)"));
  EXPECT_THAT(fleet_error("seed: 1", {{"title", ""}}), HasSubstr("expected a text, found nothing"));
}

// --- assets and files ---

TEST(Assets, AreOverriddenByObjectKeys) {
  const FleetConfig fleet = read_fleet("boats: [{model: dinghy, noise: {sigma_range_m: 0.5}}]");
  const BoatConfig& boat = fleet.boats[0];
  EXPECT_EQ(boat.model, "dinghy");
  EXPECT_EQ(boat.rate_hz, 20.0);
  EXPECT_EQ(boat.noise.sigma_range_m, 0.5);
  EXPECT_EQ(boat.noise.drop_probability, 0.25);
  EXPECT_EQ(boat.drive.as<SailConfig>().area_m2, 7.0);
  EXPECT_EQ(boat.crew.size(), 2u);
}

TEST(Assets, AllowInheritanceAndNamingByPath) {
  EXPECT_EQ(read_fleet("boats: [{model: raft}]").boats[0].noise.drop_probability, 0.25);
  EXPECT_EQ(read_fleet("boats: [{model: raft}]").boats[0].rate_hz, 2.0);
  const BoatConfig own = read_fleet("boats: [{model: own.yaml}]").boats[0];
  EXPECT_EQ(own.rate_hz, 7.0);
  EXPECT_EQ(own.model, "/in/own.yaml");
}

TEST(Assets, MistakesInsideNameTheAsset) {
  EXPECT_EQ(
      fleet_error("boats: [{model: leaky}, {model: leaky}]"),
      "/assets/boats/leaky.yaml:1:10: boats[0].rate_hz: expected a number > 0, found \"-1\"\n"
      "/assets/boats/leaky.yaml:2:1: boats[0].sigma: expected one of \"model\", \"name\", \"rate_hz\", \"tilt_deg\", "
      "\"speed_mps\", \"drag_N_per_mps\", \"width_px\", \"position_m\", \"noise\", \"crew\", \"drive\", found "
      "\"sigma\"");
}

TEST(Assets, SuggestCorrectionsForUnknownNames) {
  EXPECT_EQ(
      fleet_error("boats: [{model: dingy}]"),
      "fleet.yaml:1:17: boats[0].model: expected a name from assets/boats (one of \"dinghy\", \"leaky\", \"raft\", "
      "\"vain\"), found \"dingy\"; did you mean \"dinghy\"?");
  EXPECT_THAT(fleet_error("boats: [{model: vain}]"),
              StartsWith("/assets/boats/vain.yaml:1:8: boats[0].model: expected an asset that builds on"));
  EXPECT_THAT(fleet_error("boats: [{crew: [{type: pilot, model: wind}]}]"),
              HasSubstr("expected an asset of type \"pilot\", found \"wind\", which is of type \"sail\""));
  EXPECT_EQ(read_fleet("boats: [{crew: [{type: pilot, model: ann}]}]").boats[0].crew[0].as<PilotConfig>().reaction_s,
            0.1);
}

TEST(Files, AreResolvedBesideTheReferringFile) {
  EXPECT_EQ(read_fleet("chart: ../in/chart.csv").chart, "/in/chart.csv");
  EXPECT_EQ(read_fleet("chart: \"\"").chart, "");
  EXPECT_EQ(fleet_error("chart: chrt.csv"),
            "fleet.yaml:1:8: chart: expected an existing file, found \"chrt.csv\", which does not exist; did you mean "
            "\"chart.csv\"?");
}

TEST(ReadConfig, RefusesMissingFilesAndFolders) {
  const auto message = [](const std::string& path) {
    FleetConfig fleet;
    try {
      read_config(path, [&](ConfigVisitor& v) { fleet.visit(v); });
    } catch (const InputError& problem) {
      return std::string(problem.what());
    }
    return std::string();
  };
  EXPECT_EQ(message("nowhere/absent.yaml"), "nowhere/absent.yaml: expected a configuration file, found none");
  EXPECT_THAT(message(SWIFTLET_SOURCE_DIR), HasSubstr("expected a configuration file, found none"));
  EXPECT_THAT(message("/dev/zero"), HasSubstr("expected a configuration file, found none"));
}

}  // namespace
}  // namespace swiftlet::sim
