// SPDX-License-Identifier: BSD-3-Clause
// Guarantees of the recorders beyond their formats, which tests/readers checks with independent readers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <regex>
#include <set>

#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/recorders/csv.hpp"
#include "swiftlet/sim/recorders/events.hpp"
#include "swiftlet/sim/recorders/map.hpp"
#include "swiftlet/sim/recorders/mcap.hpp"
#include "swiftlet/sim/recorders/pcd.hpp"
#include "swiftlet/sim/recorders/rosbag.hpp"
#include "swiftlet/sim/recorders/tum.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "tests/support/config_checks.hpp"
#include "tests/support/file_size_limit.hpp"
#include "tests/support/recorder_types.hpp"
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
  for (const char* type : recorders_of_any_run()) {
    const TemporaryDirectory directory;
    SyntheticRun run(directory.path());
    const auto paths = record(run, Module(recorder_module_types(), type));
    EXPECT_FALSE(paths.empty()) << type;
    for (const fs::path& path : paths) EXPECT_TRUE(fs::exists(directory.path() / path)) << type << " " << path;
  }
}

TEST(Recorders, WriteIdenticalBytesForIdenticalRuns) {
  for (const char* type : recorders_of_any_run()) {
    std::vector<std::string> contents[2];
    for (auto& content : contents) {
      const TemporaryDirectory directory;
      SyntheticRun run(directory.path());
      record(run, Module(recorder_module_types(), type));
      std::set<fs::path> files;
      for (const auto& entry : fs::recursive_directory_iterator(directory.path())) {
        if (entry.is_regular_file()) files.insert(entry.path());
      }
      for (const fs::path& file : files) content.push_back(read_whole_file(file));
    }
    EXPECT_EQ(contents[0], contents[1]) << type;
  }
}

/// Times of a recording [ns]: numbers with nine decimals, stamps in headers of clouds, times of events.
std::vector<TimeNs> times_in(const fs::path& directory) {
  std::set<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    if (entry.is_regular_file()) files.insert(entry.path());
  }
  std::vector<TimeNs> times;
  const std::regex time("(?:^|[, ])(-?[0-9]+)\\.([0-9]{9})(?=[, ]|$)|stamp_ns ([0-9]+)|\"t_s\":([0-9.]+)");
  for (const fs::path& file : files) {
    for (const std::string& line : lines_of(file)) {
      if (line.find('\0') != std::string::npos) break;  // the points themselves
      for (std::sregex_iterator match(line.begin(), line.end(), time), end; match != end; ++match) {
        const std::smatch& m = *match;
        times.push_back(m[1].matched   ? std::stoll(m[1].str() + m[2].str())
                        : m[3].matched ? std::stoll(m[3])
                                       : std::llround(std::stold(m[4]) * 1e9L));
      }
    }
  }
  return times;
}

TEST(Recorders, TimesCountFromTheStartTime) {
  constexpr TimeNs kStart = 1'700'000'000 * kNsPerSecond;
  CsvConfig csv;
  csv.topics = {"imu", "gnss", "detections", "messages", "message_neighbor"};
  MapConfig map;
  map.times_s = {0.1};
  const std::pair<const char*, Module> recorders[] = {
      {"tum", Module(recorder_module_types(), "tum")},       {"csv", module_of("csv", csv)},
      {"events", Module(recorder_module_types(), "events")}, {"pcd", Module(recorder_module_types(), "pcd")},
      {"ply", Module(recorder_module_types(), "ply")},       {"map", module_of("map", map)}};
  for (const auto& [type, module] : recorders) {
    const TemporaryDirectory from_zero, from_epoch;
    SyntheticRun run(from_zero.path()), moved(from_epoch.path(), kStart);
    record(run, module);
    record(moved, module);
    const auto times = times_in(from_zero.path()), moved_times = times_in(from_epoch.path());
    ASSERT_EQ(times.size(), moved_times.size()) << type;
    EXPECT_GT(times.size(), 1U) << type;
    int durations = 0;  // number of sweep durations in the tables of scans
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (moved_times[i] == times[i]) {
        ++durations;
      } else {
        EXPECT_NEAR(static_cast<double>(moved_times[i] - times[i] - kStart), 0.0, 500.0) << type;
      }
    }
    EXPECT_LT(2 * durations, static_cast<int>(times.size())) << type;
  }
}

TEST(Recorders, EveryTypeWorksWhenNothingHappens) {
  for (const char* type : recorders_of_any_run()) {
    const TemporaryDirectory directory;
    SyntheticRun run(directory.path());
    EXPECT_NO_THROW(record(run, Module(recorder_module_types(), type), 0)) << type;
  }
}

TEST(Recorders, NameFileOnAFullDisk) {
  const std::pair<const char*, const char*> files[] = {{"tum", "trajectories/uav1.tum"},
                                                       {"csv", "csv/uav1/state.csv"},
                                                       {"events", "events.jsonl"},
                                                       {"pcd", "scans/uav1_os1/000000.pcd"},
                                                       {"ply", "scans/uav1_os1/000000.ply"},
                                                       {"map", "maps/uav1_detector_end.ply"},
                                                       {"mcap", "record.mcap"},
                                                       {"rosbag", "record.bag"}};
  for (const auto& [type, file] : files) {
    const TemporaryDirectory directory;
    SyntheticRun run(directory.path());
    const Module recorder(recorder_module_types(), type);
    const auto record_on_full_disk = [&] {
      const FileSizeLimit full(0);
      record(run, recorder);
    };
    EXPECT_THAT(record_on_full_disk,
                ThrowsMessage<std::runtime_error>(::testing::AllOf(HasSubstr(file), HasSubstr("File too large"))))
        << type;
    EXPECT_FALSE(fs::exists(directory.path() / file)) << type;
  }
}

TEST(Recorders, WriteOnlyTheNamedVehicles) {
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

TEST(Csv, HasHeaderFieldsInEveryRow) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  CsvConfig config;
  config.topics = {"state",     "imu",        "gnss",   "odometry", "altimeter", "compass",         "pose",
                   "neighbors", "detections", "tracks", "scores",   "messages",  "message_neighbor"};
  const auto paths = record(run, module_of("csv", config));
  EXPECT_EQ(paths.size(), 2 * config.topics.size());
  for (const fs::path& path : paths) {
    const auto lines = lines_of(directory.path() / path);
    ASSERT_GT(lines.size(), 5U) << path;
    for (const std::string& line : lines) EXPECT_EQ(num_fields(line), num_fields(lines[0])) << path << ": " << line;
  }
}

/// Column names used by other programs: renaming or moving a field changes the format.
TEST(Csv, NamesColumnsByFieldAndUnit) {
  const std::string covariance = "cov_xx_m2,cov_xy_m2,cov_xz_m2,cov_yy_m2,cov_yz_m2,cov_zz_m2";
  const std::string pose = "x_m,y_m,z_m,qx,qy,qz,qw", velocity = "vx_mps,vy_mps,vz_mps";
  const std::string rate = "omega_x_radps,omega_y_radps,omega_z_radps";
  const std::pair<const char*, std::string> headers[] = {
      {"state", "t_s," + pose + "," + velocity + "," + rate +
                    ",crashed,clearance_m,"
                    "est_t_s,est_x_m,est_y_m,est_z_m,est_qx,est_qy,est_qz,est_qw,est_vx_mps,est_vy_mps,est_vz_mps,"
                    "est_omega_x_radps,est_omega_y_radps,est_omega_z_radps,"
                    "ref_x_m,ref_y_m,ref_z_m,ref_vx_mps,ref_vy_mps,ref_vz_mps,ref_ax_mps2,ref_ay_mps2,ref_az_mps2,"
                    "ref_yaw_rad,ref_yaw_rate_radps,rotor0_radps,rotor1_radps,rotor2_radps,rotor3_radps"},
      {"imu", "t_s," + rate + ",f_x_mps2,f_y_mps2,f_z_mps2"},
      {"gnss", "t_s,x_m,y_m,z_m," + velocity + ",sigma_x_m,sigma_y_m,sigma_z_m,sigma_vx_mps,sigma_vy_mps,sigma_vz_mps"},
      {"odometry", "t_s," + pose + "," + velocity},
      {"altimeter", "t_s,height_m,sigma_m"},
      {"compass", "t_s,yaw_rad,sigma_rad"},
      {"pose", "t_s," + pose + "," + velocity + "," + rate},
      {"neighbors", "t_s,neighbor,x_body_m,y_body_m,z_body_m," + covariance},
      {"detections",
       "t_s,x_m,y_m,z_m," + covariance + ",extent_x_m,extent_y_m,extent_z_m,num_points,confidence,reflectivity"},
      {"tracks",
       "t_s,id,x_m,y_m,z_m," + velocity + ",ax_mps2,ay_mps2,az_mps2," + covariance +
           ",num_detections,corrected,measured_x_m,measured_y_m,measured_z_m,measured_cov_xx_m2,measured_cov_xy_m2,"
           "measured_cov_xz_m2,measured_cov_yy_m2,measured_cov_yz_m2,measured_cov_zz_m2,reflectivity"},
      {"relatives", "t_s,other,x_m,y_m,z_m," + velocity + ",yaw_rad," + covariance +
                        ",seen_s,heard_s,heard_stamp_s,heard_x_m,heard_y_m,heard_z_m,heard_yaw_rad"},
      {"scores",
       "t_s,stage,target,distance_m,visible_points,found,id,position_error_m,speed_error_mps,direction_error_rad,nees,"
       "latency_s"},
      {"message_odometry", "t_s," + pose + "," + velocity + ",yaw_rate_radps,path,num_visited,sender,received_s"},
      {"message_guiding_path", "path,command,radius_m,has_instant,t_s,num_waypoints,sender,received_s"},
      {"message_neighbor", "t_s,x_m,y_m,z_m,sender,received_s"}};
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  CsvConfig config;
  config.topics.clear();
  for (const auto& [topic, header] : headers) config.topics.emplace_back(topic);
  record(run, module_of("csv", config), 1);
  for (const auto& [topic, header] : headers) {
    EXPECT_EQ(lines_of(directory.path() / "csv/uav1" / (std::string(topic) + ".csv"))[0], header);
  }
}

TEST(Csv, WritesRunSeriesOnlyWithRows) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  CsvConfig config;
  config.topics = {"spread"};
  const auto paths = record(run, module_of("csv", config), 3);
  EXPECT_THAT(paths, ElementsAre("csv/uav1/spread.csv", "csv/uav-2/spread.csv", "csv/spread.csv"));
  const auto lines = lines_of(directory.path() / "csv/spread.csv");
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_EQ(lines[0], "t_s,spread_m");
  EXPECT_EQ(lines[3].substr(0, 12), "0.020000000,");
  EXPECT_EQ(lines_of(directory.path() / "csv/uav1/spread.csv").size(), 1U);
}

TEST(Csv, ListsNewerMessagesWithoutReadingThem) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  CsvConfig config;
  config.topics = {"messages", "message_neighbor"};
  record(run, module_of("csv", config), 6);  // the first and the fourth are of another version
  EXPECT_EQ(lines_of(directory.path() / "csv/uav1/messages.csv").size(), 1U + 6U);
  const auto read = lines_of(directory.path() / "csv/uav1/message_neighbor.csv");
  ASSERT_EQ(read.size(), 1U + 4U);
  EXPECT_EQ(num_fields(read[1]), num_fields(read[0]));
  EXPECT_THAT(read[1], HasSubstr(",uav-2,"));
}

TEST(Csv, RefusesTablesWithoutASource) {
  CsvConfig config;
  config.topics = {"imu", "scores", "weather"};
  const std::vector<std::string> problems = swiftlet::test::ConfigChecks(config).problems();
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_THAT(problems[0], HasSubstr("topics: expected a list of state, imu, "));
  EXPECT_THAT(problems[0], HasSubstr("scores"));
  config.topics = {"imu", "scores"};
  EXPECT_THAT(swiftlet::test::ConfigChecks(config).problems(), ::testing::IsEmpty());
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

/// Runs a straight flight with an estimate offset by `offset`, and returns the x of a point 5 m ahead of a LiDAR at the
/// center of the body, measured half-way through a sweep of 100 ms.
float x_in_frame(ScanFilesConfig::Frame frame, double offset_m) {
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
    actions[0].estimate.T_local_body = pose_at(0.02 * k, offset_m);
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

TEST(ScanFiles, SupportLidarWorldAndEstimatedFrames) {
  EXPECT_FLOAT_EQ(x_in_frame(ScanFilesConfig::Frame::kLidar, 0.25), 5.0F);
  // the vehicle has flown 0.5 m when the beam fires
  EXPECT_FLOAT_EQ(x_in_frame(ScanFilesConfig::Frame::kWorld, 0.25), 5.5F);
  EXPECT_FLOAT_EQ(x_in_frame(ScanFilesConfig::Frame::kWorldEstimate, 0.25),
                  5.75F);  // estimated 0.25 m further ahead
}

TEST(Csv, RefusesTwoRecordersOfSameFiles) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  const auto first = make_recorder(Module(recorder_module_types(), "csv"));
  const auto second = make_recorder(Module(recorder_module_types(), "csv"));
  first->begin(run.info());
  EXPECT_THAT([&] { second->begin(run.info()); }, ThrowsMessage<std::runtime_error>(HasSubstr("another recorder")));
}

/// Bytes that the open recorder has written so far must grow with the run, so that its memory does not.
TEST(Recorders, WriteBagsDuringTheRun) {
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
