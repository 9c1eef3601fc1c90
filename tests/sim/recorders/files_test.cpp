// SPDX-License-Identifier: BSD-3-Clause
// Files of scans and maps, read by their own headers; tables and events by their lines.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "sim/recorders/scan_files.hpp"
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

std::string bytes_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

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

/// Points of a binary PCD or PLY file, as its header describes them.
struct CloudFile {
  explicit CloudFile(const fs::path& path) {
    const std::string bytes = bytes_of(path);
    const bool pcd = bytes.starts_with("# .PCD");
    const std::string end = pcd ? "\nDATA binary\n" : "\nend_header\n";
    const std::size_t body = bytes.find(end) + end.size();
    std::vector<std::pair<char, std::size_t>> types;  // F or U, and how many bytes
    for (const std::string& line : split(bytes.substr(0, body), '\n')) {
      std::vector<std::string> words = split(line, ' ');
      if (line.starts_with("#") || line.starts_with("comment")) comments.push_back(line.substr(line.find(' ') + 1));
      if (words.size() < 2) continue;
      const std::string key = words[0];
      words.erase(words.begin());
      if (pcd) {
        header[key] = words;
      } else if (key == "element") {
        header["POINTS"] = {words[1]};
      } else if (key == "property") {
        header["FIELDS"].push_back(words[1]);
        types.emplace_back(words[0] == "float" ? 'F' : 'U', words[0] == "uchar" ? 1U : words[0] == "ushort" ? 2U : 4U);
      }
    }
    if (pcd) {
      for (std::size_t i = 0; i < header["FIELDS"].size(); ++i) {
        types.emplace_back(header["TYPE"].at(i)[0], std::stoul(header["SIZE"].at(i)));
        EXPECT_EQ(header["COUNT"].at(i), "1");
      }
      EXPECT_EQ(header["VERSION"][0], "0.7");
      EXPECT_THAT(header["VIEWPOINT"], ElementsAre("0", "0", "0", "1", "0", "0", "0"));
      width = std::stoul(header["WIDTH"][0]);
      height = std::stoul(header["HEIGHT"][0]);
      EXPECT_EQ(std::to_string(width * height), header["POINTS"][0]);
    }
    std::size_t at = body;
    for (std::size_t i = 0; i < std::stoul(header["POINTS"].at(0)); ++i) {
      auto& point = points.emplace_back();
      for (std::size_t k = 0; k < types.size(); ++k) {
        point[header["FIELDS"][k]] = number(bytes.substr(at, types[k].second), types[k].first);
        at += types[k].second;
      }
    }
    EXPECT_EQ(at, bytes.size()) << path;
  }
  static double number(const std::string& bytes, char type) {
    if (type == 'F') {
      float value = 0.0F;
      std::memcpy(&value, bytes.data(), sizeof value);
      return static_cast<double>(value);
    }
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data(), bytes.size());
    return value;
  }

  std::map<std::string, std::vector<std::string>> header;
  std::vector<std::string> comments;
  std::size_t width = 0, height = 0;
  std::vector<std::map<std::string, double>> points;
};

template <class Config>
std::unique_ptr<Recorder> recorder_of(const char* type, const Config& config) {
  Module module(recorder_module_types(), type);
  module.as<Config>() = config;
  return make_recorder(module);
}

void expect_points_of(const LabeledScan& labeled, bool organized, const CloudFile& file) {
  const Scan& scan = labeled.scan;
  std::size_t k = 0;
  for (int i = 0; i < scan.size(); ++i) {
    const auto n = static_cast<std::size_t>(i);
    if (!organized && !scan.hit(i)) continue;
    ASSERT_LT(k, file.points.size());
    auto point = file.points[k++];
    ASSERT_EQ(point.size(), 13U);
    const Eigen::Vector3f p = scan.point_lidar(i);
    for (int axis = 0; axis < 3; ++axis) {
      const double found = point.at(std::string(1, "xyz"[axis]));
      if (scan.hit(i)) {
        EXPECT_EQ(found, static_cast<double>(p[axis]));
      } else {
        EXPECT_TRUE(std::isnan(found)) << "an empty return has no place";
      }
    }
    EXPECT_EQ(point["intensity"], static_cast<double>(scan.intensity[n]));
    EXPECT_EQ(point["reflectivity"], static_cast<double>(scan.reflectivity[n]));
    EXPECT_EQ(point["ring"], i / scan.cols());
    EXPECT_EQ(point["column"], i % scan.cols());
    EXPECT_EQ(point["t"], static_cast<double>(scan.time_of(i) - scan.stamp));
    EXPECT_EQ(point["class"], labeled.truth.surface_class[n]);
    EXPECT_EQ(point["instance"], labeled.truth.instance[n]);
    EXPECT_EQ(point["part"], labeled.truth.part[n]);
    EXPECT_EQ(point["range_true"], static_cast<double>(labeled.truth.range_m[n]));
    EXPECT_EQ(point["incidence"], static_cast<double>(labeled.truth.incidence_rad[n]));
  }
  EXPECT_EQ(k, file.points.size());
}

TEST(ScanFiles, PointsAndIndexRoundTrip) {
  for (const std::string format : {"pcd", "organized", "ply"}) {
    const TemporaryDirectory directory;
    SyntheticRun run(directory.path());
    const bool organized = format == "organized";
    const std::string extension = organized ? "pcd" : format;
    PcdConfig pcd;
    pcd.organized = organized;
    const auto recorder = extension == "pcd" ? recorder_of("pcd", pcd) : recorder_of("ply", PlyConfig());
    recorder->begin(run.info());
    std::vector<std::shared_ptr<const LabeledScan>> scans[2];
    for (int k = 0; k <= 20; ++k) {
      const TickView& view = run.tick(k);
      recorder->write(view);
      for (std::size_t v = 0; v < 2; ++v) scans[v].insert(scans[v].end(), view.scans[v].begin(), view.scans[v].end());
    }
    const auto folders = recorder->finish();
    EXPECT_THAT(folders, UnorderedElementsAre("scans/uav1_os1", "scans/uav-2_mid360", "scans/uav-2_puck"));
    EXPECT_EQ(names_in(directory.path() / "scans/uav-2_mid360"),
              (std::set<std::string>{"000000." + extension, "000001." + extension, extension + "_index.csv"}));
    for (const auto& [folder, v, first] :
         {std::tuple("uav1_os1", 0, 0), std::tuple("uav-2_mid360", 1, 0), std::tuple("uav-2_puck", 1, 1)}) {
      const fs::path path = directory.path() / "scans" / folder;
      const auto lines = split(bytes_of(path / (extension + "_index.csv")), '\n');
      ASSERT_EQ(lines.size(), 3U);
      const auto head = split(lines[0], ',');
      for (std::size_t n = 0; n < 2; ++n) {
        const LabeledScan& labeled = *scans[v].at((v == 0 ? 1 : 2) * n + static_cast<std::size_t>(first));
        const Scan& scan = labeled.scan;
        const CloudFile file(path / ("00000" + std::to_string(n) + "." + extension));
        expect_points_of(labeled, organized, file);
        if (extension == "pcd") {
          EXPECT_EQ(file.width, organized ? static_cast<std::size_t>(scan.cols()) : file.points.size());
          EXPECT_EQ(file.height, organized ? static_cast<std::size_t>(scan.rows()) : 1U);
        }
        std::string comments;
        for (const std::string& comment : file.comments) comments += comment + "\n";
        EXPECT_THAT(comments, HasSubstr("frame lidar"));
        EXPECT_THAT(comments, HasSubstr("stamp_ns " + std::to_string(scan.stamp)));

        const auto cells = split(lines[n + 1], ',');
        ASSERT_EQ(cells.size(), head.size());
        std::map<std::string, std::string> row;
        for (std::size_t i = 0; i < head.size(); ++i) row[head[i]] = cells[i];
        EXPECT_EQ(row["file"], "00000" + std::to_string(n) + "." + extension);
        EXPECT_NEAR(std::stod(row["stamp_s"]), to_seconds(scan.stamp), 1e-12);
        EXPECT_NEAR(std::stod(row["duration_s"]), to_seconds(scan.duration), 1e-12);
        EXPECT_EQ(row["rows"], std::to_string(scan.rows()));
        EXPECT_EQ(row["columns"], std::to_string(scan.cols()));
        EXPECT_EQ(row["points"], std::to_string(file.points.size()));
        const Pose& T = labeled.truth.T_world_lidar.front();
        EXPECT_EQ(std::stod(row["x_m"]), T.translation().x());
        EXPECT_EQ(std::stod(row["z_m"]), T.translation().z());
        const Eigen::Quaterniond q(std::stod(row["qw"]), std::stod(row["qx"]), std::stod(row["qy"]),
                                   std::stod(row["qz"]));
        EXPECT_LT((q.toRotationMatrix() - T.linear()).norm(), 1e-9);
        // The vehicle has estimates at the ticks 5 and 10; the first scan begins at 0.
        EXPECT_TRUE(std::isfinite(std::stod(row["est_x_m"])));
        EXPECT_TRUE(std::isfinite(std::stod(row["est_qw"])));
      }
    }
  }
}

TEST(ScanFiles, IndexOmitsMissingEstimateAndMotion) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  PcdConfig config;
  config.frame = ScanFilesConfig::Frame::kWorld;
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
  const auto cells = split(split(bytes_of(directory.path() / "scans/uav1_os1/pcd_index.csv"), '\n').at(1), ',');
  ASSERT_EQ(cells.size(), 20U);
  for (std::size_t i = 13; i < 20; ++i) EXPECT_EQ(cells[i], "nan");
  const CloudFile file(directory.path() / "scans/uav1_os1/000000.pcd");
  std::size_t k = 0;
  for (int i = 0; i < labeled->scan.size(); ++i) {
    if (!labeled->scan.hit(i)) continue;
    const Vector3 p = labeled->truth.T_world_lidar.at(0) * labeled->scan.point_lidar(i).cast<double>();
    EXPECT_EQ(file.points.at(k++).at("x"), static_cast<double>(static_cast<float>(p.x())));
  }
}

std::map<std::string, std::string> map_files(const MapConfig& config, int ticks) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  const auto recorder = recorder_of("map", config);
  recorder->begin(run.info());
  for (int k = 0; k < ticks; ++k) recorder->write(run.tick(k));
  std::map<std::string, std::string> files;
  for (const fs::path& path : recorder->finish()) files[path.string()] = bytes_of(directory.path() / path);
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
  const MapVoxels map = made_up_maps().front();
  for (const bool occupied : {false, true}) {
    for (const MapConfig::Format format : {MapConfig::Format::kPly, MapConfig::Format::kPcd}) {
      const TemporaryDirectory directory;
      SyntheticRun run(directory.path());
      MapConfig config;
      config.format = format;
      config.folder = "here";
      config.maps = {"detector"};
      config.voxels = occupied ? MapConfig::Voxels::kOccupied : MapConfig::Voxels::kAll;
      const auto recorder = recorder_of("map", config);
      recorder->begin(run.info());
      recorder->write(run.tick(6));
      const std::string extension = format == MapConfig::Format::kPly ? ".ply" : ".pcd";
      EXPECT_THAT(recorder->finish(),
                  ElementsAre("here/uav1_detector_end" + extension, "here/uav-2_detector_end" + extension));
      const CloudFile file(directory.path() / ("here/uav-2_detector_end" + extension));
      EXPECT_THAT(file.header.at("FIELDS"), ElementsAre("x", "y", "z", "state", "value"));
      std::string comments;
      for (const std::string& comment : file.comments) comments += comment + "\n";
      for (const char* told : {"map detector of uav-2\n", "frame uav-2/local\n", "stamp_ns 60000000\n", "edge_m 0.25\n",
                               "states 0 free 1 uncertain 2 tentative 3 confident\n", "world_from_local x_m 0 y_m 0"}) {
        EXPECT_THAT(comments, HasSubstr(told));
      }
      std::size_t k = 0;
      for (std::size_t i = 0; i < map.size(); ++i) {
        if (occupied && map.state[i] < 2) continue;
        ASSERT_LT(k, file.points.size());
        const auto& point = file.points[k++];
        EXPECT_EQ(point.at("x"), static_cast<double>(map.centers_local_m[i].x()));
        EXPECT_EQ(point.at("z"), static_cast<double>(map.centers_local_m[i].z()));
        EXPECT_EQ(point.at("state"), map.state[i]);
        EXPECT_EQ(point.at("value"), static_cast<double>(map.value[i]));
      }
      EXPECT_EQ(k, file.points.size());
      EXPECT_EQ(k, occupied ? 20U : 40U);
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

// Text of any encoding, times and places of whatever happened.
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
  EXPECT_EQ(bytes_of(directory.path() / "events.jsonl"),
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
  EXPECT_THAT(bytes_of(directory.path() / "events.jsonl"), ::testing::StartsWith("{\"t_s\":0.09,\"kind\":\"end\""));
}

TEST(Tum, HoldsEachPoseAndEstimateOnce) {
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
  EXPECT_THAT(recorder->finish(), ElementsAre("trajectories/uav1.tum", "trajectories/uav1.estimate.tum",
                                              "trajectories/uav-2.tum", "trajectories/uav-2.estimate.tum"));
  const auto lines = split(bytes_of(directory.path() / "trajectories/uav1.tum"), '\n');
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[1], lines[2]);
  const auto cells = split(lines[1], ' ');
  ASSERT_EQ(cells.size(), 8U);
  EXPECT_EQ(cells[0], "0.080000000");
  EXPECT_EQ(std::stod(cells[3]), view.states[0].p_world_m.z());
  EXPECT_EQ(std::stod(cells[4]), view.states[0].q_world_body.x());
  EXPECT_EQ(std::stod(cells[7]), view.states[0].q_world_body.w());
  const auto estimates = split(bytes_of(directory.path() / "trajectories/uav1.estimate.tum"), '\n');
  ASSERT_EQ(estimates.size(), 2U);
  EXPECT_THAT(estimates[1], ::testing::StartsWith("0.070000000 "));
  EXPECT_EQ(split(bytes_of(directory.path() / "trajectories/uav-2.estimate.tum"), '\n').size(), 1U);
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

TEST(Csv, RowsHoldWhatTheTickHolds) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  CsvConfig config;
  config.topics = {"state", "imu", "tracks", "detections", "scores"};
  config.rate_hz = 50.0;  // for the state only
  config.vehicles = {"uav-2"};
  const auto recorder = recorder_of("csv", config);
  recorder->begin(run.info());
  std::map<std::string, std::vector<double>> state;  // at the ticks 0, 2 and 4
  int detections = 0, tracks = 0;
  for (int k = 0; k <= 8; ++k) {
    TickView view = run.tick(k);
    if (k % 2 == 0) {
      const auto& s = view.states[1];
      const StateEstimate& estimate = view.actions[1]->estimate;
      state["t_s"].push_back(to_seconds(view.t));
      state["x_m"].push_back(s.p_world_m.x());
      state["qw"].push_back(s.q_world_body.w());
      state["vz_mps"].push_back(s.v_world_mps.z());
      state["crashed"].push_back(s.crashed ? 1 : 0);
      state["clearance_m"].push_back(k == 6 ? std::nan("") : view.clearance_m[1]);
      state["est_x_m"].push_back(estimate.valid ? estimate.T_local_body.translation().x() : std::nan(""));
      state["ref_yaw_rad"].push_back(view.actions[1]->reference.yaw_rad);
      state["rotor0_radps"].push_back(s.rotor_speed_radps[0]);
      state["rotor3_radps"].push_back(s.rotor_speed_radps[3]);
    }
    if (k == 6) view.clearance_m = {};
    detections += static_cast<int>(view.actions[1]->detections.size());
    tracks += view.actions[1]->has_tracks ? 1 : 0;
    recorder->write(view);
  }
  EXPECT_THAT(recorder->finish(),
              UnorderedElementsAre("csv/uav-2/state.csv", "csv/uav-2/imu.csv", "csv/uav-2/tracks.csv",
                                   "csv/uav-2/detections.csv", "csv/uav-2/scores.csv"));
  const auto lines_of = [&](const std::string& table) {
    return split(bytes_of(directory.path() / "csv" / (table + ".csv")), '\n');
  };
  const auto lines = lines_of("uav-2/state");
  ASSERT_EQ(lines.size(), 1U + 5U);
  const auto head = split(lines[0], ',');
  for (const auto& [name, values] : state) {
    const auto column = static_cast<std::size_t>(std::find(head.begin(), head.end(), name) - head.begin());
    ASSERT_LT(column, head.size()) << name;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double found = std::stod(split(lines[i + 1], ',').at(column));
      if (std::isnan(values[i])) {
        EXPECT_TRUE(std::isnan(found)) << name;
      } else {
        EXPECT_DOUBLE_EQ(found, values[i]) << name << " of row " << i;
      }
    }
  }
  EXPECT_EQ(std::count(head.begin(), head.end(), "rotor4_radps"), 0);
  EXPECT_EQ(lines_of("uav-2/imu").size(), 1U + 2U * 9U);
  EXPECT_EQ(lines_of("uav-2/detections").size(), 1U + static_cast<std::size_t>(detections));
  EXPECT_EQ(lines_of("uav-2/tracks").size(), 1U + static_cast<std::size_t>(tracks));
  EXPECT_EQ(lines_of("uav-2/scores").size(), 1U + 2U * 9U);
  EXPECT_EQ(names_in(directory.path() / "csv/uav1").size(), 0U);
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
  EXPECT_EQ(split(bytes_of(directory.path() / "csv/uav1/state.csv"), '\n').size(), 2U);
  EXPECT_EQ(split(bytes_of(directory.path() / "csv/uav1/detections.csv"), '\n').size(), 1U);
  EXPECT_EQ(split(bytes_of(directory.path() / "csv/uav1/tracks.csv"), '\n').size(), 1U);
}

TEST(Csv, ListsTablesOnceWithFirstRotor) {
  std::set<std::string> names;
  for (const TableType& table : csv_tables()) {
    EXPECT_TRUE(names.insert(table.name).second) << table.name;
    if (table.name != "state") continue;
    EXPECT_EQ(table.columns.back().name, "rotor0_radps");
  }
  for (const char* name : {"state", "imu", "tracks", "messages", "message_neighbor", "scores"})
    EXPECT_TRUE(names.contains(name)) << name;
}

/// The layout contains the names required by its viewers, and the visibility of each topic.
TEST(Mcap, TheLayoutShowsCloudsAndMarkers) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  McapConfig config;
  config.file = "flight.mcap";
  const auto recorder = recorder_of("mcap", config);
  recorder->begin(run.info());
  for (int k = 0; k <= 10; ++k) recorder->write(run.tick(k));
  EXPECT_THAT(recorder->finish(), ElementsAre("flight.mcap", "flight.layout.json"));
  const auto layout = nlohmann::json::parse(bytes_of(directory.path() / "flight.layout.json"));
  EXPECT_EQ(layout.at("layout"), "3D!scene");
  EXPECT_EQ(layout.at("playbackConfig").at("speed"), 1) << "as fast as it was flown";
  const auto& scene = layout.at("configById").at("3D!scene");
  EXPECT_EQ(scene.at("followTf"), "world");
  const auto& camera = scene.at("cameraState");
  EXPECT_EQ(camera.at("perspective"), true);
  EXPECT_EQ(camera.at("target"), (nlohmann::json{0, 0, 0}));
  EXPECT_EQ(camera.at("targetOffset"), (nlohmann::json{0, 0, 0}));
  EXPECT_GT(camera.at("distance"), camera.at("near"));
  EXPECT_LT(camera.at("distance"), camera.at("far"));
  const auto& topics = scene.at("topics");
  EXPECT_EQ(topics.at("/uav1/os1/points").at("visible"), true);
  EXPECT_EQ(topics.at("/uav_2/detections").at("visible"), true);
  EXPECT_EQ(topics.at("/uav1/tracks").at("namespaces").at("names").at("visible"), true);
  EXPECT_EQ(topics.at("/uav1/detections").at("namespaces").at("names").at("visible"), false);
  EXPECT_EQ(topics.size(), 3U + 4U) << "poses and samples have no place in space";
  const std::string bytes = bytes_of(directory.path() / "flight.mcap");
  EXPECT_EQ(bytes.substr(1, 4), "MCAP");
}

/// Values of rmw's policies: history keep last, reliable; volatile, or transient local for late subscribers.
TEST(Mcap, LatchedTopicIsTransientLocal) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  McapConfig config;
  config.compression = McapConfig::Compression::kNone;
  config.topics = {"points", "tf"};
  config.sensors = {"os1"};
  const auto recorder = recorder_of("mcap", config);
  recorder->begin(run.info());
  for (int k = 0; k <= 10; ++k) recorder->write(run.tick(k));
  recorder->finish();
  const std::string bytes = bytes_of(directory.path() / "record.mcap");
  const auto profile_of = [&](const std::string& topic) {
    const std::size_t at = bytes.find("offered_qos_profiles", bytes.find(topic + std::string("\x03\0\0\0cdr", 7)));
    return bytes.substr(at, bytes.find("avoid_ros", at) - at);
  };
  EXPECT_THAT(profile_of("/tf_static"), HasSubstr("depth: 1\n"));
  EXPECT_THAT(profile_of("/tf_static"), HasSubstr("durability: 1\n"));
  EXPECT_THAT(profile_of("/uav1/os1/points"), HasSubstr("depth: 10\n"));
  EXPECT_THAT(profile_of("/uav1/os1/points"), HasSubstr("durability: 2\n"));
}

}  // namespace
}  // namespace swiftlet::sim
