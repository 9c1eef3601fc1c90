// SPDX-License-Identifier: BSD-3-Clause
// What the recorders write and what they leave out; tests/readers checks every value with independent readers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "sim/recorders/scan_files.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/recorders/csv.hpp"
#include "swiftlet/sim/recorders/events.hpp"
#include "swiftlet/sim/recorders/map.hpp"
#include "swiftlet/sim/recorders/mcap.hpp"
#include "swiftlet/sim/recorders/pcd.hpp"
#include "swiftlet/sim/recorders/ply.hpp"
#include "swiftlet/sim/recorders/tum.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "tests/support/synthetic_run.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, at);) words.push_back(word);
  return words;
}

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  if (!fs::exists(folder)) return names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

template <class Config>
std::unique_ptr<Recorder> recorder_of(const char* type, const Config& config) {
  Module module(recorder_module_types(), type);
  module.as<Config>() = config;
  return make_recorder(module);
}

TEST(ScanFiles, IndexListsScansWithTheirPoses) {
  for (const std::string type : {"pcd", "ply"}) {
    const TemporaryDirectory directory;
    SyntheticRun run(directory.path());
    const auto recorder = make_recorder(Module(recorder_module_types(), type));
    recorder->begin(run.info());
    std::vector<std::shared_ptr<const LabeledScan>> scans;  // from the mid360
    for (int k = 0; k <= 20; ++k) {
      const TickView& view = run.tick(k);
      recorder->write(view);
      if (!view.scans[1].empty()) scans.push_back(view.scans[1].front());
    }
    EXPECT_THAT(recorder->finish(), UnorderedElementsAre("scans/uav1_os1", "scans/uav-2_mid360", "scans/uav-2_puck"));
    const fs::path folder = directory.path() / "scans/uav-2_mid360";
    EXPECT_EQ(names_in(folder), (std::set<std::string>{"000000." + type, "000001." + type, type + "_index.csv"}));
    const auto lines = split(read_whole_file(folder / (type + "_index.csv")), '\n');
    ASSERT_EQ(lines.size(), 3U);
    const auto head = split(lines[0], ',');
    for (std::size_t n = 0; n < 2; ++n) {
      const Scan& scan = scans.at(n)->scan;
      const auto cells = split(lines[n + 1], ',');
      ASSERT_EQ(cells.size(), head.size());
      std::map<std::string, std::string> row;
      for (std::size_t i = 0; i < head.size(); ++i) row[head[i]] = cells[i];
      EXPECT_EQ(row["file"], "00000" + std::to_string(n) + "." + type);
      EXPECT_NEAR(std::stod(row["stamp_s"]), to_seconds(scan.stamp), 1e-12);
      EXPECT_NEAR(std::stod(row["duration_s"]), to_seconds(scan.duration), 1e-12);
      EXPECT_EQ(row["rows"], std::to_string(scan.rows()));
      EXPECT_EQ(row["columns"], std::to_string(scan.cols()));
      const Pose& T = scans[n]->truth.T_world_lidar.front();
      EXPECT_EQ(std::stod(row["z_m"]), T.translation().z());
      const Eigen::Quaterniond q(std::stod(row["qw"]), std::stod(row["qx"]), std::stod(row["qy"]),
                                 std::stod(row["qz"]));
      EXPECT_LT((q.toRotationMatrix() - T.linear()).norm(), 1e-9);
      EXPECT_TRUE(std::isfinite(std::stod(row["est_x_m"])));
      EXPECT_THAT(read_whole_file(folder / row["file"]),
                  AllOf(HasSubstr("frame lidar"), HasSubstr("stamp_ns " + std::to_string(scan.stamp))));
    }
  }
}

TEST(ScanFiles, IndexOmitsMissingEstimateAndMotion) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  PcdConfig config;
  config.vehicles = {"uav1"};
  const auto recorder = recorder_of("pcd", config);
  recorder->begin(run.info());
  const auto labeled = run.make_scan("os1", run.make_beams(2, 3), 0, false);
  const std::vector<std::shared_ptr<const LabeledScan>> scans[2] = {{labeled}, {labeled}};
  const VehicleState states[2];
  const Observation observations[2];
  const Action* const actions[2] = {nullptr, nullptr};
  TickView view;
  view.states = states;
  view.observations = observations;
  view.actions = actions;
  recorder->write(view);  // without scans
  view.scans = scans;
  recorder->write(view);
  EXPECT_THAT(recorder->finish(), ElementsAre("scans/uav1_os1"));
  const auto cells = split(split(read_whole_file(directory.path() / "scans/uav1_os1/pcd_index.csv"), '\n').at(1), ',');
  ASSERT_EQ(cells.size(), 20U);
  for (std::size_t i = 13; i < 20; ++i) EXPECT_EQ(cells[i], "nan");
}

std::map<std::string, std::string> map_files(const MapConfig& config, int ticks) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  const auto recorder = recorder_of("map", config);
  recorder->begin(run.info());
  for (int k = 0; k < ticks; ++k) recorder->write(run.tick(k));
  std::map<std::string, std::string> files;
  for (const fs::path& path : recorder->finish()) files[path.string()] = read_whole_file(directory.path() / path);
  return files;
}

TEST(Maps, AreWrittenAtInstantsAndEnd) {
  MapConfig config;
  config.vehicles = {"uav1"};
  config.maps = {"mapping"};
  config.times_s = {0.05, 0.015, 0.5};
  const auto files = map_files(config, 8);
  std::map<std::string, std::string> stamps;
  for (const auto& [name, bytes] : files) {
    const std::size_t at = bytes.find("comment stamp_ns ") + 17;
    stamps[name] = bytes.substr(at, bytes.find('\n', at) - at);
  }
  EXPECT_EQ(stamps, (std::map<std::string, std::string>{{"maps/uav1_mapping_000000.015s.ply", "20000000"},
                                                        {"maps/uav1_mapping_000000.050s.ply", "50000000"},
                                                        {"maps/uav1_mapping_end.ply", "70000000"}}));
  config.at_end = false;
  EXPECT_EQ(map_files(config, 8).size(), 2U);
  config.at_end = true;
  config.vehicles.clear();
  config.maps.clear();
  config.times_s.clear();
  std::set<std::string> all;
  for (const auto& [name, bytes] : map_files(config, 1)) all.insert(name);
  EXPECT_EQ(all, (std::set<std::string>{"maps/uav1_detector_end.ply", "maps/uav1_mapping_end.ply",
                                        "maps/uav-2_detector_end.ply", "maps/uav-2_mapping_end.ply"}));
}

TEST(Maps, HoldAllOrOnlyOccupiedVoxels) {
  for (const auto& [voxels, count] : {std::pair(MapConfig::Voxels::kAll, "40"), {MapConfig::Voxels::kOccupied, "20"}}) {
    for (const auto& [format, end] : {std::pair(MapConfig::Format::kPly, ".ply"), {MapConfig::Format::kPcd, ".pcd"}}) {
      MapConfig config;
      config.format = format;
      config.folder = "here";
      config.maps = {"detector"};
      config.voxels = voxels;
      const auto files = map_files(config, 7);
      ASSERT_EQ(files.size(), 2U);
      const std::string& content = files.at(std::string("here/uav-2_detector_end") + end);
      for (const char* expected :
           {"map detector of uav-2\n", "frame uav-2/local\n", "stamp_ns 60000000\n", "edge_m 0.25\n",
            "states 0 free 1 uncertain 2 tentative 3 confident\n", "world_from_local x_m 0 y_m 0"}) {
        EXPECT_THAT(content, HasSubstr(expected));
      }
      EXPECT_THAT(content,
                  HasSubstr((format == MapConfig::Format::kPly ? "vertex " : "POINTS ") + std::string(count) + "\n"));
    }
  }
}

TEST(Maps, WriteValidOctreesOnlyWithAgents) {
  for (const auto& [format, head] : {std::pair(MapConfig::Format::kOt, "# Octomap OcTree file"),
                                     std::pair(MapConfig::Format::kBt, "# Octomap OcTree binary file")}) {
    MapConfig config;
    config.format = format;
    config.vehicles = {"uav1"};
    config.maps = {"mapping"};
    const auto files = map_files(config, 1);
    ASSERT_EQ(files.size(), 1U);
    EXPECT_TRUE(files.begin()->second.starts_with(head));
    EXPECT_TRUE(files.begin()->first.ends_with(format == MapConfig::Format::kOt ? ".ot" : ".bt"));
  }
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  const auto recorder = recorder_of("map", MapConfig());
  recorder->begin(run.info());
  TickView view = run.tick(0);
  const std::unique_ptr<Agent> none[2];
  view.agents = none;
  recorder->write(view);
  EXPECT_THAT(recorder->finish(), IsEmpty());
}

// Text of any encoding, times and places.
TEST(Events, AreALineOfJsonEach) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  const auto recorder = recorder_of("events", EventsConfig());
  recorder->begin(run.info());
  TickView view = run.tick(0);
  const Event events[] = {{90'000'000, "crash", 0, "B\xC3\xA4ume", {1.5, -2, 0.25}, "one\ntwo"},
                          {1'250'000'000, "end", kNoVehicle, "\xFF", {0, 0, 0}, ""}};
  view.events = events;
  recorder->write(view);
  EXPECT_THAT(recorder->finish(), ElementsAre("events.jsonl"));
  EXPECT_EQ(read_whole_file(directory.path() / "events.jsonl"),
            "{\"t_s\":0.09,\"kind\":\"crash\",\"vehicle\":\"uav1\",\"partner\":\"B\xC3\xA4ume\","
            "\"position_m\":[1.5,-2.0,0.25],\"note\":\"one\\ntwo\"}\n"
            "{\"t_s\":1.25,\"kind\":\"end\",\"vehicle\":null,\"partner\":\"\xEF\xBF\xBD\","
            "\"position_m\":[0.0,0.0,0.0],\"note\":\"\"}\n");
}

TEST(Events, KeepOnlyNamedVehiclesAndRun) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  EventsConfig config;
  config.vehicles = {"uav1"};
  const auto recorder = recorder_of("events", config);
  recorder->begin(run.info());
  for (int k = 0; k <= 9; ++k) recorder->write(run.tick(k));
  recorder->finish();
  EXPECT_THAT(read_whole_file(directory.path() / "events.jsonl"),
              ::testing::StartsWith("{\"t_s\":0.09,\"kind\":\"end\""));
}

TEST(Tum, HoldsEachEstimateOnce) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  TumConfig config;
  config.rate_hz = 0.0;
  const auto recorder = recorder_of("tum", config);
  recorder->begin(run.info());
  TickView view = run.tick(8);
  Action action = *view.actions[0];
  action.estimate.t = 70'000'000;
  const Action* const actions[2] = {&action, nullptr};
  view.actions = actions;
  recorder->write(view);
  recorder->write(view);  // no newer estimate, although the tick is written again
  recorder->finish();
  EXPECT_EQ(split(read_whole_file(directory.path() / "trajectories/uav1.tum"), '\n').size(), 3U);
  const auto estimates = split(read_whole_file(directory.path() / "trajectories/uav1.estimate.tum"), '\n');
  ASSERT_EQ(estimates.size(), 2U);
  EXPECT_THAT(estimates[1], ::testing::StartsWith("0.070000000 "));
  EXPECT_EQ(split(read_whole_file(directory.path() / "trajectories/uav-2.estimate.tum"), '\n').size(), 1U);
}

TEST(Tum, WithoutEstimatesOmitsTheirFile) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  TumConfig config;
  config.estimate = false;
  const auto recorder = recorder_of("tum", config);
  recorder->begin(run.info());
  recorder->write(run.tick(8));
  EXPECT_THAT(recorder->finish(), ElementsAre("trajectories/uav1.tum", "trajectories/uav-2.tum"));
  EXPECT_EQ(names_in(directory.path() / "trajectories"), (std::set<std::string>{"uav1.tum", "uav-2.tum"}));
}

TEST(Csv, LimitsTheStateToItsRate) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  CsvConfig config;
  config.topics = {"state", "imu", "detections", "scores"};
  config.rate_hz = 50.0;
  config.vehicles = {"uav-2"};
  const auto recorder = recorder_of("csv", config);
  recorder->begin(run.info());
  std::size_t detections = 0;
  for (int k = 0; k <= 8; ++k) {
    const TickView& view = run.tick(k);
    detections += view.actions[1]->detections.size();
    recorder->write(view);
  }
  EXPECT_EQ(recorder->finish().size(), 4U);
  const auto num_lines = [&](const std::string& table) {
    return split(read_whole_file(directory.path() / "csv/uav-2" / (table + ".csv")), '\n').size();
  };
  EXPECT_EQ(num_lines("state"), 1U + 5U);
  EXPECT_EQ(num_lines("imu"), 1U + 2U * 9U);
  EXPECT_EQ(num_lines("detections"), 1U + detections);
  EXPECT_EQ(num_lines("scores"), 1U + 2U * 9U);
  EXPECT_TRUE(names_in(directory.path() / "csv/uav1").empty());
}

TEST(Csv, OmitsEmptyTablesAndUnmeasuredRows) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  CsvConfig config;
  config.topics.clear();
  const auto none = recorder_of("csv", config);
  none->begin(run.info());
  none->write(run.tick(0));
  EXPECT_THAT(none->finish(), IsEmpty());
  config.topics = {"state", "detections", "tracks"};
  config.vehicles = {"uav1"};
  const auto recorder = recorder_of("csv", config);
  recorder->begin(run.info());
  TickView view = run.tick(0);
  const Action* const actions[2] = {nullptr, nullptr};
  view.actions = actions;
  recorder->write(view);
  recorder->finish();
  EXPECT_EQ(split(read_whole_file(directory.path() / "csv/uav1/state.csv"), '\n').size(), 2U);
  EXPECT_EQ(split(read_whole_file(directory.path() / "csv/uav1/detections.csv"), '\n').size(), 1U);
  EXPECT_EQ(split(read_whole_file(directory.path() / "csv/uav1/tracks.csv"), '\n').size(), 1U);
}

TEST(Mcap, TheLayoutShowsCloudsAndMarkers) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  McapConfig config;
  config.file = "flight.mcap";
  const auto recorder = recorder_of("mcap", config);
  recorder->begin(run.info());
  for (int k = 0; k <= 10; ++k) recorder->write(run.tick(k));
  EXPECT_THAT(recorder->finish(), ElementsAre("flight.mcap", "flight.layout.json"));
  const auto layout = nlohmann::json::parse(read_whole_file(directory.path() / "flight.layout.json"));
  EXPECT_EQ(layout.at("layout"), "3D!scene");
  const auto& scene = layout.at("configById").at("3D!scene");
  EXPECT_EQ(scene.at("followTf"), "world");
  const auto& topics = scene.at("topics");
  EXPECT_EQ(topics.at("/uav1/os1/points").at("visible"), true);
  EXPECT_EQ(topics.at("/uav_2/detections").at("visible"), true);
  EXPECT_EQ(topics.at("/uav1/tracks").at("visible"), true);
  EXPECT_EQ(topics.size(), 3U + 4U) << "poses and samples have no place in space";
}

}  // namespace
}  // namespace swiftlet::sim
