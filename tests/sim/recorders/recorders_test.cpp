// SPDX-License-Identifier: BSD-3-Clause
// What the recorders promise beyond their formats, which tests/readers checks with independent readers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <set>
#include <sstream>

#include "sim/recorders/csv.hpp"
#include "sim/recorders/events.hpp"
#include "sim/recorders/mcap.hpp"
#include "sim/recorders/pcd.hpp"
#include "sim/recorders/rosbag.hpp"
#include "sim/recorders/tum.hpp"
#include "tests/support/synthetic_run.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::size_t num_fields(const std::string& line) { return std::count(line.begin(), line.end(), ',') + 1; }

template <class Config>
Module module_of(const char* type, const Config& config) {
  Module module(recorder_module_types(), type);
  module.as<Config>() = config;
  return module;
}

std::vector<fs::path> record(SyntheticRun& run, const Module& module, int num_ticks = 31) {
  const auto recorder = make_recorder(module);
  recorder->begin(run.info());
  for (int k = 0; k < num_ticks; ++k) recorder->write(run.tick(k));
  return recorder->finish();
}

TEST(Recorders, EveryTypeRecordsWithItsDefaults) {
  for (const ModuleType& type : recorder_module_types()) {
    const TemporaryDirectory directory;
    SyntheticRun run(directory.path());
    const auto paths = record(run, Module(recorder_module_types(), type.name));
    EXPECT_FALSE(paths.empty()) << type.name;
    for (const fs::path& path : paths) EXPECT_TRUE(fs::exists(directory.path() / path)) << type.name << " " << path;
  }
}

TEST(Recorders, TheSameRunGivesTheSameBytes) {
  for (const ModuleType& type : recorder_module_types()) {
    std::vector<std::string> contents[2];
    for (auto& content : contents) {
      const TemporaryDirectory directory;
      SyntheticRun run(directory.path());
      record(run, Module(recorder_module_types(), type.name));
      std::set<fs::path> files;
      for (const auto& entry : fs::recursive_directory_iterator(directory.path())) {
        if (entry.is_regular_file()) files.insert(entry.path());
      }
      for (const fs::path& file : files) {
        std::ostringstream text;
        text << std::ifstream(file, std::ios::binary).rdbuf();
        content.push_back(text.str());
      }
    }
    EXPECT_EQ(contents[0], contents[1]) << type.name;
  }
}

TEST(Recorders, EveryTypeWorksWhenNothingHappens) {
  for (const ModuleType& type : recorder_module_types()) {
    const TemporaryDirectory directory;
    SyntheticRun run(directory.path());
    EXPECT_NO_THROW(record(run, Module(recorder_module_types(), type.name), 0)) << type.name;
  }
}

TEST(Recorders, AFullDiskIsAnErrorThatNamesTheFile) {
  const std::pair<const char*, const char*> files[] = {{"tum", "trajectories/uav1.tum"},
                                                       {"csv", "csv/uav1/state.csv"},
                                                       {"events", "events.jsonl"},
                                                       {"pcd", "scans/uav1_os1/000000.pcd"},
                                                       {"ply", "scans/uav1_os1/000000.ply"},
                                                       {"mcap", "record.mcap"},
                                                       {"rosbag", "record.bag"}};
  for (const auto& [type, file] : files) {
    const TemporaryDirectory directory;
    fs::create_directories((directory.path() / file).parent_path());
    fs::create_symlink("/dev/full", directory.path() / (std::string(file) + ".part"));
    SyntheticRun run(directory.path());
    EXPECT_THAT([&] { record(run, Module(recorder_module_types(), type)); },
                ThrowsMessage<std::runtime_error>(::testing::AllOf(HasSubstr(file), HasSubstr("No space left"))))
        << type;
    EXPECT_FALSE(fs::exists(directory.path() / file)) << type;
  }
}

TEST(Recorders, WriteOnlyTheVehiclesThatAreNamed) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  TumConfig config;
  config.vehicles = {"uav-2"};
  config.estimate = false;
  EXPECT_THAT(record(run, module_of("tum", config)), ElementsAre(fs::path("trajectories/uav-2.tum")));
}

TEST(Tum, WritesAtTheGivenRate) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  TumConfig config;
  config.rate_hz = 20.0;
  record(run, module_of("tum", config));  // 0 .. 0.3 s
  const auto lines = lines_of(directory.path() / "trajectories/uav1.tum");
  ASSERT_EQ(lines.size(), 1U + 7U);
  EXPECT_EQ(lines[2].substr(0, 12), "0.050000000 ");
  // The estimate is valid from 0.05 s on.
  EXPECT_EQ(lines_of(directory.path() / "trajectories/uav1.estimate.tum").size(), 1U + 6U);
}

TEST(Csv, EveryRowHasAsManyFieldsAsTheHeader) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  CsvConfig config;
  config.topics = {"state",   "imu",  "gnss",      "odometry",   "altimeter",
                   "compass", "pose", "neighbors", "detections", "tracks"};
  const auto paths = record(run, module_of("csv", config));
  EXPECT_EQ(paths.size(), 2 * config.topics.size());
  for (const fs::path& path : paths) {
    const auto lines = lines_of(directory.path() / path);
    ASSERT_GT(lines.size(), 5U) << path;
    for (const std::string& line : lines) EXPECT_EQ(num_fields(line), num_fields(lines[0])) << path << ": " << line;
  }
}

TEST(Events, CanBeChosenByKind) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  EventsConfig config;
  config.kinds = {"crash"};
  record(run, module_of("events", config));
  const auto lines = lines_of(directory.path() / "events.jsonl");
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_THAT(lines[0], HasSubstr("\"kind\":\"crash\",\"vehicle\":\"uav-2\",\"partner\":\"trunk \\\"17\\\"\""));
}

TEST(ScanFiles, EveryNthScanIsWritten) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  PcdConfig config;
  config.every = 2;
  config.sensors = {"os1"};
  record(run, module_of("pcd", config), 61);  // six scans
  const fs::path folder = directory.path() / "scans/uav1_os1";
  EXPECT_TRUE(fs::exists(folder / "000002.pcd"));
  EXPECT_FALSE(fs::exists(folder / "000003.pcd"));
  EXPECT_FALSE(fs::exists(directory.path() / "scans/uav-2_puck"));
  const auto index = lines_of(folder / "pcd_index.csv");
  ASSERT_EQ(index.size(), 4U);
  EXPECT_EQ(index[2].substr(0, 34), "000001.pcd,0.200000000,0.100000000");
  for (const std::string& line : index) EXPECT_EQ(num_fields(line), num_fields(index[0]));
}

/// Runs a straight flight whose estimate is `offset` beside it, and returns the x of a point 5 m ahead of a LiDAR in
/// the middle of the body, seen half-way through a sweep of 100 ms.
float x_in_frame(const std::string& frame, double offset_m) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 1;
  beams->cols = 2;
  beams->directions_lidar = {Eigen::Vector3f::UnitX(), Eigen::Vector3f::UnitX()};
  beams->origins_lidar.resize(2, Eigen::Vector3f::Zero());
  beams->column_offset_s = {0.0F, 0.05F};
  auto labeled = run.make_scan("lidar", beams, 0, true);
  labeled->scan.T_body_lidar = Pose::Identity();
  labeled->scan.range_m = {0.0F, 5.0F};

  // 10 m/s along x.
  const auto pose_at = [](double t_s, double dx) {
    return make_pose({10.0 * t_s + dx, 0, 0}, Eigen::Quaterniond::Identity());
  };
  labeled->truth.T_world_lidar = {pose_at(0, 0), pose_at(0.05, 0)};

  PcdConfig config;
  config.frame = frame;
  const auto recorder = make_recorder(module_of("pcd", config));
  recorder->begin(run.info());
  Action actions[2];
  const Action* pointers[2] = {&actions[0], &actions[1]};
  const VehicleState states[2];
  const Observation observations[2];
  for (int k = 0; k <= 5; ++k) {
    std::vector<std::shared_ptr<const LabeledScan>> scans[2];
    if (k == 5) scans[0] = {labeled};
    actions[0].estimate.valid = true;
    actions[0].estimate.t = k * 20'000'000;
    actions[0].estimate.T_world_body = pose_at(0.02 * k, offset_m);
    TickView tick;
    tick.t = k * 20'000'000;
    tick.states = states;
    tick.observations = observations;
    tick.actions = pointers;
    tick.scans = scans;
    recorder->write(tick);
  }
  recorder->finish();
  std::ifstream file(directory.path() / "scans/uav1_lidar/000000.pcd", std::ios::binary);
  std::string line;
  while (std::getline(file, line) && line != "DATA binary") {
  }
  float x = 0;
  file.read(reinterpret_cast<char*>(&x), sizeof x);
  return x;
}

TEST(ScanFiles, FramesAreTheLidarTheTrueWorldAndTheEstimatedWorld) {
  EXPECT_FLOAT_EQ(x_in_frame("lidar", 0.25), 5.0F);
  EXPECT_FLOAT_EQ(x_in_frame("world", 0.25), 5.5F);            // flown 0.5 m when the beam was fired
  EXPECT_FLOAT_EQ(x_in_frame("world_estimate", 0.25), 5.75F);  // and believed to be 0.25 m further
}

TEST(Csv, TwoRecordersOfTheSameFilesAreRefused) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  const auto first = make_recorder(Module(recorder_module_types(), "csv"));
  const auto second = make_recorder(Module(recorder_module_types(), "csv"));
  first->begin(run.info());
  EXPECT_THAT([&] { second->begin(run.info()); }, ThrowsMessage<std::runtime_error>(HasSubstr("another recorder")));
}

/// Bytes that the open recorder has written so far must grow with the run, so that its memory does not.
TEST(Recorders, BagsAreWrittenWhileTheRunGoesOn) {
  for (const char* type : {"mcap", "rosbag"}) {
    const TemporaryDirectory directory;
    SyntheticRun run(directory.path());
    const auto recorder = make_recorder(Module(recorder_module_types(), type));
    recorder->begin(run.info());
    for (int k = 0; k < 2000; ++k) recorder->write(run.tick(k));
    std::uintmax_t written = 0;
    for (const auto& entry : fs::directory_iterator(directory.path())) written += entry.file_size();
    recorder->finish();
    std::uintmax_t complete = 0;
    for (const auto& entry : fs::directory_iterator(directory.path())) complete += entry.file_size();
    EXPECT_GT(written, complete / 2) << type;
  }
}

}  // namespace
}  // namespace swiftlet::sim
