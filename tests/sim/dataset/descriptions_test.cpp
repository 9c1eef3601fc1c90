// SPDX-License-Identifier: BSD-3-Clause
// Descriptions of a dataset: data card, class table, manifest, descriptions of sequences.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "sim/dataset/data_card.hpp"
#include "sim/dataset/hash.hpp"
#include "sim/dataset/sequence_recorder.hpp"
#include "swiftlet/sim/dataset/generate.hpp"
#include "swiftlet/sim/plot/plot.hpp"
#include "swiftlet/sim/render/colors.hpp"
#include "tests/sim/dataset/read_files.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

DatasetPlan plan_of(const std::vector<SplitConfig>& splits) {
  DatasetPlan plan;
  plan.config.name = "pair";
  plan.config.splits = splits;
  plan.fingerprint = "beef";
  return plan;
}

SequenceInfo sequence_of(int number, const std::string& split, std::uint64_t bytes = 1000) {
  SequenceInfo info;
  info.sequence = number;
  info.split = split;
  info.files = {{"a", bytes, "00"}};
  return info;
}

std::string card_of(const DatasetPlan& plan, const std::vector<SequenceInfo>& sequences) {
  const TemporaryDirectory directory;
  write_data_card(plan, sequences, directory.path());
  return read_whole_file(directory.path() / "README.md");
}

TEST(DataCard, CountsSequencesAndFlightsPerSplit) {
  const DatasetPlan plan = plan_of({{"train", 3, 5}, {"valid", 0, 9}, {"test", 1, 11}});
  std::vector<SequenceInfo> sequences = {sequence_of(0, "train"), sequence_of(1, "train"), sequence_of(2, "train"),
                                         sequence_of(3, "test")};
  const int flights[] = {0, 0, 1, 3};
  for (std::size_t i = 0; i < 4; ++i) {
    sequences[i].flight = flights[i];
    SequenceStatistics& s = sequences[i].statistics;
    s.frames = 400;
    s.points = i == 3 ? 999 : 1'234'567;
    s.duration_s = 10.25;
    s.flown_m = 100.5;
    s.vehicles_by_range[3].boxes = 7;
    s.vehicles_by_range[49].boxes = 1;
  }
  const std::string card = card_of(plan, sequences);
  EXPECT_THAT(card, HasSubstr("\n| train | 5 to 7 | 2 | 3 | 1 200 | 3 703 701 | 24 | 31 s | 302 m | 3 kB |\n"));
  EXPECT_THAT(card, HasSubstr("\n| valid | 9 to 9 | 0 | 0 | 0 | 0 | 0 | 0 s | 0 m | 0 kB |\n"));
  EXPECT_THAT(card, HasSubstr("\n| test | 11 to 11 | 1 | 1 | 400 | 999 | 8 | 10 s | 100 m | 1 kB |\n"));
  EXPECT_THAT(card, HasSubstr("\n| all |  | 3 | 4 | 1 600 | 3 704 700 | 32 | 41 s | 402 m | 4 kB |\n"));
  EXPECT_THAT(card, ::testing::StartsWith("# pair\n\nSimulated by Swiftlet "));
  EXPECT_THAT(card, HasSubstr("fingerprint of the configuration `beef`"));
}

TEST(DataCard, StatesShareOfPosesOutsideWalls) {
  const DatasetPlan plan = plan_of({{"train", 2, 5}, {"valid", 1, 9}});
  std::vector<SequenceInfo> sequences = {sequence_of(0, "train"), sequence_of(1, "train"), sequence_of(2, "valid")};
  for (SequenceInfo& info : sequences) info.statistics.frames = 40;
  EXPECT_EQ(poses_outside(sequences), "");
  EXPECT_THAT(card_of(plan, sequences), Not(HasSubstr("outside walls")));
  // Sequence 01, in a forest, has no walls: its poses are not counted.
  sequences[0].statistics.frames_walled = 40;
  sequences[0].statistics.frames_outside = 5;
  sequences[2].statistics.frames_walled = 40;
  sequences[2].statistics.frames_outside = 40;
  EXPECT_THAT(card_of(plan, sequences),
              HasSubstr("\n\n56.2 % of 80 poses lie outside walls (train 12.5 %, valid 100.0 %).\n\n"));
}

TEST(DataCard, ShowsSizesInFittingUnits) {
  const std::pair<std::uint64_t, const char*> sizes[] = {
      {1499, "1 kB"}, {1'260'000, "1.3 MB"}, {12'340'000'000, "12.34 GB"}};
  for (const auto& [bytes, text] : sizes) {
    EXPECT_THAT(card_of(plan_of({{"train", 1, 1}}), {sequence_of(0, "train", bytes)}),
                HasSubstr("| 0 m | " + std::string(text) + " |\n| all"));
  }
}

TEST(DataCard, SortsClassesByNumberOfPoints) {
  SequenceInfo info = sequence_of(0, "train");
  info.statistics.points = 1'000'000;
  info.statistics.points_by_class = {{40, 700'000}, {70, 250'000}, {71, 1000}, {53, 999}, {0, 999}, {300, 47'002}};
  info.statistics.vehicles_by_range[2].points = 40'000;
  info.statistics.vehicles_by_range[7].points = 2;
  const std::string card = card_of(plan_of({{"train", 1, 1}}), {info});
  EXPECT_THAT(card, HasSubstr("| --- | --- | --- | --- |\n"
                              "| ground | 40 | 700 000 | 70.00 % |\n"
                              "| vegetation | 70 | 250 000 | 25.00 % |\n"
                              "| vehicle | 300 | 47 002 | 4.70 % |\n"
                              "| - other vehicles | | 40 002 | |\n"
                              "| - the LiDAR's own carrier | | 7 000 | |\n"
                              "| trunk | 71 | 1 000 | 0.10 % |\n"
                              "| unlabeled | 0 | 999 | 0.0999 % |\n"
                              "| pillar | 53 | 999 | 0.0999 % |\n\n"));
}

TEST(DataCard, ListsSequencesAndVariedSettings) {
  DatasetPlan plan = plan_of({{"train", 2, 5}});
  plan.config.description = "Two flights.";
  FamilyConfig family;
  family.name = "plane";
  family.vary = {{"world.num_trees", VariationConfig::Law::kWhole, 3, 40, {}},
                 {"world.type", VariationConfig::Law::kChoice, 0, 1, {"forest", "empty"}}};
  family.reflectivity_spread = 0.25;
  family.flight.speed_min_mps = 1.5;
  family.flight.height_max_m = 7.0;
  plan.config.families = {family, FamilyConfig()};
  plan.config.families[1].name = "still";
  SequenceInfo first = sequence_of(0, "train"), second = sequence_of(112, "train");
  first.seed = 5;
  first.family = "plane";
  first.vehicle = "uav1";
  first.sensor = "os";
  first.sensor_model = "os1_128";
  first.models = {"f330", "x500"};
  first.statistics.frames = 3;
  first.statistics.points = 10'000;
  first.statistics.flown_m = 12.4;
  first.statistics.least_clearance_m = 0.756;
  second.vehicle = "uav2";
  second.sensor = "mid";
  second.statistics.points = 5;
  second.statistics.least_clearance_m = 2.0;
  const std::string card = card_of(plan, {first, second});
  EXPECT_THAT(card,
              HasSubstr("| 00 | train | 5 | plane | uav1/os (os1_128) | f330, x500 | 3 | 3 333 | 12 m | 0.76 m |\n"
                        "| 112 | train | 0 |  | uav2/mid |  | 0 | 5 | 0 m | 2.00 m |\n"));
  EXPECT_THAT(card, HasSubstr("# pair\n\nTwo flights.\n\nSimulated"));
  EXPECT_THAT(card, HasSubstr("| plane | `world.num_trees` | whole | 3 to 40 |\n"
                              "| plane | `world.type` | choice | forest, empty |\n"
                              "| plane | reflectivity of each material | log-normal | x exp(0.25 n) |\n"
                              "| plane | cruise speed | uniform | 1.5 to 3 m/s |\n"
                              "| plane | height above ground | uniform | 1.5 to 7 m |\n"
                              "| still | cruise speed | uniform | 1 to 3 m/s |\n"
                              "| still | height above ground | uniform | 1.5 to 5 m |\n\n"));
  EXPECT_THAT(card, Not(HasSubstr("## Pictures")));
}

TEST(DataCard, ShowsOnlySnapshots) {
  SequenceInfo info = sequence_of(7, "train");
  info.files = {{"images/range/000000.png", 1, ""},
                {"snapshots/side_1.png", 1, ""},
                {"snapshots/side_1.mm.png", 1, ""},
                {"snapshots/side.json", 1, ""}};
  const std::string card = card_of(plan_of({{"train", 1, 1}}), {info});
  EXPECT_THAT(card, HasSubstr("## Pictures\n\n![sequence 07, side_1](sequences/07/snapshots/side_1.png)\n\n## Random"));
}

/// Lines below one top-level key of the class table (YAML), without their indentation.
std::vector<std::string> block(const std::string& table, const std::string& key) {
  std::vector<std::string> lines;
  std::istringstream in(table);
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(' ')) inside = line.starts_with(key + ":");
    if (inside && line.starts_with(' ')) lines.push_back(line.substr(2));
  }
  return lines;
}

TEST(ClassTable, MapsClassesDenselyAndStatesShares) {
  SequenceInfo one = sequence_of(3, "train"), two = sequence_of(4, "valid"), three = sequence_of(5, "train");
  one.statistics.points = 5;
  one.statistics.points_by_class = {{40, 3}, {300, 2}};
  two.statistics.points = 3;
  two.statistics.points_by_class = {{40, 3}};
  const std::string table = class_table(plan_of({{"train", 1, 1}, {"valid", 1, 2}, {"test", 1, 3}}), {one, two, three});
  const auto labels = block(table, "labels"), content = block(table, "content"), colors = block(table, "color_map"),
             learning = block(table, "learning_map"), inverse = block(table, "learning_map_inv"),
             ignore = block(table, "learning_ignore");
  ASSERT_GT(labels.size(), 10U);
  std::set<std::string> seen;
  int previous = -1;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::string number = labels[i].substr(0, labels[i].find(':'));
    EXPECT_GT(std::stoi(number), previous);
    previous = std::stoi(number);
    EXPECT_TRUE(seen.insert(labels[i].substr(labels[i].find('"'))).second);
    EXPECT_EQ(content.at(i), number + (number == "40"    ? ": 0.750000000"
                                       : number == "300" ? ": 0.250000000"
                                                         : ": 0.000000000"));
    EXPECT_EQ(learning.at(i), number + ": " + std::to_string(i));
    EXPECT_EQ(inverse.at(i), std::to_string(i) + ": " + number);
    EXPECT_EQ(ignore.at(i), std::to_string(i) + (i == 0 ? ": True" : ": False"));
  }
  EXPECT_EQ(labels.front(), "0: \"unlabeled\"");
  EXPECT_THAT(labels, ::testing::Contains("300: \"vehicle\""));
  EXPECT_EQ(colors.front(), "0: [0, 0, 0]");
  const Eigen::Vector3i ground_rgb = (255.0F * class_color(40).cast<float>()).array().round().matrix().cast<int>();
  EXPECT_THAT(colors, ::testing::Contains("40: [" + std::to_string(ground_rgb.z()) + ", " +
                                          std::to_string(ground_rgb.y()) + ", " + std::to_string(ground_rgb.x()) + "]"))
      << "colors are in the order blue, green, red";
  EXPECT_THAT(block(table, "split"), ElementsAre("train:", "  - 3", "  - 5", "valid:", "  - 4", "test: []"));
  // A data set without points has zero shares.
  EXPECT_THAT(block(class_table(plan_of({}), {}), "content").at(1), HasSubstr(": 0.000000000"));
}

SequenceInfo full_sequence() {
  SequenceInfo info;
  info.sequence = 7;
  info.split = "valid";
  info.flight = 3;
  info.seed = 18'000'000'000'000'000'000U;
  info.attempt = 2;
  info.family = "plane";
  info.vehicle = "uav2";
  info.instance = 2;
  info.sensor = "os";
  info.sensor_model = "os1_128";
  info.vehicles = {"uav1", "uav2"};
  info.models = {"f330", "x500"};
  info.state_hash = "abc";
  info.fingerprint = "def";
  info.version = "1.2";
  info.revision = "r";
  info.reflectivities = {0.1, 0.30000000000000004};
  SequenceStatistics& s = info.statistics;
  s.frames = 12;
  s.points = 1'234'567'890'123;
  s.rows = 64;
  s.columns = 1024;
  s.duration_s = 1.5;
  s.flown_m = 2.25;
  s.least_clearance_m = 0.75;
  s.frames_walled = 12;
  s.frames_outside = 7;
  s.points_by_class = {{0, 1}, {40, 2}, {65'535, 3}};
  for (std::size_t i = 0; i < s.points_by_range.size(); ++i) {
    const auto n = static_cast<std::int64_t>(i);
    s.points_by_range[i] = 10 * n + 1;
    s.vehicles_by_range[i] = {10 * n + 2, 10 * n + 3, 10 * n + 4, 10 * n + 5, 10 * n + 6};
  }
  s.pixel_shift_by_row = {0, -3, 5};
  info.files = {{"a", 1, "00"}, {"b/c", 5'000'000'000, "ff"}};
  return info;
}

TEST(SequenceInfo, RoundTripsThroughJson) {
  const TemporaryDirectory directory;
  const SequenceInfo info = full_sequence();
  std::ofstream(directory.path() / "sequence.json") << to_json(info);
  const SequenceInfo read = read_sequence_info(directory.path());
  EXPECT_EQ(to_json(read), to_json(info));
  EXPECT_EQ(read.sequence, 7);
  EXPECT_EQ(read.seed, info.seed);
  EXPECT_EQ(read.reflectivities, info.reflectivities);
  EXPECT_EQ(read.statistics.points_by_class, info.statistics.points_by_class);
  EXPECT_EQ(read.statistics.points_by_range, info.statistics.points_by_range);
  EXPECT_EQ(read.statistics.vehicles_by_range[49].points, info.statistics.vehicles_by_range[49].points);
  EXPECT_EQ(read.files.at(1).bytes, 5'000'000'000U);
  const auto json = nlohmann::json::parse(to_json(info));
  EXPECT_EQ(json.at("sequence"), "07");
  EXPECT_EQ(json.at("statistics").at("range_bin_m"), 2.0);
  EXPECT_EQ(json.at("statistics").at("points_by_class").at("65535"), 3);
}

TEST(SequenceInfo, RefusesInvalidDescriptionsNamingTheKey) {
  const TemporaryDirectory directory;
  const fs::path file = directory.path() / "sequence.json";
  EXPECT_THAT([&] { read_sequence_info(directory.path()); },
              ThrowsMessage<std::runtime_error>(HasSubstr("cannot read " + file.string())));
  const auto expect_refused = [&](const auto& change, const std::string& reason) {
    auto json = nlohmann::json::parse(to_json(full_sequence()));
    change(json);
    std::ofstream(file) << json;
    EXPECT_THAT([&] { read_sequence_info(directory.path()); }, ThrowsMessage<std::runtime_error>(HasSubstr(reason)));
  };
  expect_refused([](auto& json) { json["sequence"] = "seven"; }, "expected a number, found \"seven\"");
  expect_refused([](auto& json) { json["statistics"]["points_by_class"] = {{"65536", 1}}; }, "found \"65536\"");
  expect_refused([](auto& json) { json["statistics"]["points_by_range"].erase(49); },
                 "not the description of a sequence");
  expect_refused([](auto& json) { json["statistics"]["vehicles_by_range"]["points"].erase(49); },
                 "not the description");
  expect_refused([](auto& json) { json["flight"] = "first"; }, "flight: expected a whole number, found something else");
  expect_refused([](auto& json) { json["flight"] = 1e300; }, "flight: expected a whole number");
  expect_refused([](auto& json) { json["flight"] = 1LL << 40; }, "flight: expected a whole number");
  expect_refused([](auto& json) { json["seed"] = -1; }, "seed: expected a whole number >= 0");
  expect_refused([](auto& json) { json["vehicles"] = {"a", 1}; }, "vehicles: expected a list, each element a text");
  expect_refused([](auto& json) { json["statistics"] = 3; }, "statistics: expected an object");
  expect_refused([](auto& json) { json["statistics"]["points"] = 2'000'000'000'000'000; }, "points: expected a count");
  const auto valid = nlohmann::json::parse(to_json(full_sequence()));
  for (const auto& item : valid.items())
    expect_refused([&](auto& json) { json.erase(item.key()); }, "not the description of a sequence");
}

TEST(SequenceInfo, PadsSequenceAndFileNumbers) {
  EXPECT_EQ(sequence_name(0), "00");
  EXPECT_EQ(sequence_name(7), "07");
  EXPECT_EQ(sequence_name(113), "113");
  EXPECT_EQ(frame_file("velodyne", 12, "bin"), "velodyne/000012.bin");
}

TEST(ListFiles, ListsFilesWithSizeAndHash) {
  const TemporaryDirectory directory;
  fs::create_directories(directory.path() / "b/sub");
  fs::create_directories(directory.path() / "left");
  std::ofstream(directory.path() / "z.txt") << "abc";
  std::ofstream(directory.path() / "b/sub/x") << "1234";
  std::ofstream(directory.path() / "b/sequence.json") << "{}";
  std::ofstream(directory.path() / "sequence.json") << "{}";
  std::ofstream(directory.path() / "left/out") << "";
  const auto files = list_files(directory.path(), {{"z.txt", 99, "known"}, {"a", 1, "gone"}}, "left");
  ASSERT_EQ(files.size(), 3U);
  EXPECT_EQ(files[0].path, "b/sequence.json");
  EXPECT_EQ(files[1].path, "b/sub/x");
  EXPECT_EQ(files[1].bytes, 4U);
  EXPECT_EQ(files[1].xxh128, hex(hash_of("1234")));
  EXPECT_EQ(files[2].path, "z.txt");
  EXPECT_EQ(files[2].bytes, 99U) << "a file with a known hash is not read again";
  EXPECT_EQ(files[2].xxh128, "known");
  EXPECT_EQ(list_files(directory.path()).size(), 4U);
}

TEST(Hash, MatchesHashOfFileBytes) {
  const TemporaryDirectory directory;
  // Expected digests of the first two texts: xxhsum -H128.
  EXPECT_EQ(hex(hash_of("")), "99aa06d3014798d86001c324468d497f");
  EXPECT_EQ(hex(hash_of("a")), "a96faf705af16834e6c632b61e964e1f");
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, (std::size_t{1} << 18) - 1, std::size_t{1} << 18, std::size_t{700'001}}) {
    std::string text(size, 'x');
    for (std::size_t i = 0; i < size; i += 97) text[i] = static_cast<char>(i);
    std::ofstream(directory.path() / "f", std::ios::binary) << text;
    EXPECT_EQ(hash_of_file(directory.path() / "f"), hash_of(text)) << size;
  }
  EXPECT_THAT([&] { hash_of_file(directory.path() / "none"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("none: No such file")));
  EXPECT_THAT([&] { hash_of_file(directory.path()); }, ThrowsMessage<std::runtime_error>(HasSubstr("Is a directory")));
}

TEST(Manifest, NamesEveryFileOfEverySequence) {
  DatasetPlan plan = plan_of({{"train", 3, 5}, {"valid", 1, 9}});
  plan.config.description = "about";
  SequenceInfo info = full_sequence();
  const auto json = nlohmann::json::parse(manifest_json(plan, {info}, {{"README.md", 5, "aa"}}, true));
  EXPECT_EQ(json.at("dataset"), "pair");
  EXPECT_EQ(json.at("description"), "about");
  EXPECT_EQ(json.at("complete"), true);
  EXPECT_EQ(json.at("fingerprint"), "beef");
  EXPECT_EQ(json.at("splits").at("train"), (nlohmann::json{{"first_seed", 5}, {"flights", 3}}));
  EXPECT_EQ(json.at("files"),
            (nlohmann::json{{{"path", "README.md"}, {"bytes", 5}, {"xxh128", "aa"}},
                            {{"path", "sequences/07/a"}, {"bytes", 1}, {"xxh128", "00"}},
                            {{"path", "sequences/07/b/c"}, {"bytes", 5'000'000'000}, {"xxh128", "ff"}}}));
  EXPECT_EQ(json.at("sequences").at(0), (nlohmann::json{{"sequence", "07"},
                                                        {"split", "valid"},
                                                        {"flight", 3},
                                                        {"seed", info.seed},
                                                        {"attempt", 2},
                                                        {"family", "plane"},
                                                        {"vehicle", "uav2"},
                                                        {"sensor", "os"},
                                                        {"frames", 12},
                                                        {"points", 1'234'567'890'123},
                                                        {"state_hash", "abc"}}));
  const auto incomplete = nlohmann::json::parse(manifest_json(plan, {}, {}, false));
  EXPECT_EQ(incomplete.at("complete"), false);
  EXPECT_TRUE(incomplete.at("files").is_array() && incomplete.at("sequences").is_array());
}

TEST(SequenceStatistics, AddUpAndKeepLeastClearance) {
  SequenceStatistics a = full_sequence().statistics, b = full_sequence().statistics;
  b.points_by_class = {{40, 10}, {70, 5}};
  b.least_clearance_m = 0.5;
  SequenceStatistics sum;
  sum.add(a);
  EXPECT_EQ(sum.least_clearance_m, 0.75);
  sum.add(b);
  EXPECT_EQ(sum.frames, 24);
  EXPECT_EQ(sum.points, 2 * 1'234'567'890'123);
  EXPECT_EQ(sum.points_by_class, (std::map<std::uint16_t, std::int64_t>{{0, 1}, {40, 12}, {70, 5}, {65'535, 3}}));
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_EQ(sum.points_by_range[i], 2 * a.points_by_range[i]);
    EXPECT_EQ(sum.vehicles_by_range[i].boxes, 2 * a.vehicles_by_range[i].boxes);
    EXPECT_EQ(sum.vehicles_by_range[i].points, 2 * a.vehicles_by_range[i].points);
  }
  EXPECT_EQ(sum.flown_m, 4.5);
  EXPECT_EQ(sum.duration_s, 3.0);
  EXPECT_EQ(sum.least_clearance_m, 0.5);
  EXPECT_EQ(sum.frames_walled, 24);
  EXPECT_EQ(sum.frames_outside, 14);
}

}  // namespace
}  // namespace swiftlet::sim
