// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/scenario.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/stage_tables/detectors.hpp"
#include "swiftlet/core/stage_tables/estimators.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"
#include "swiftlet/core/stage_tables/mappers.hpp"
#include "swiftlet/core/stage_tables/trackers.hpp"
#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/scenario/assets.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"
#include "swiftlet/sim/scenario/yaml_writer.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

Scenario read_scenario_text(const std::string& text) {
  Scenario scenario;
  read_config_text(text, "flight.yaml", [&](ConfigVisitor& v) { scenario.visit(v); });
  return scenario;
}

std::string scenario_error(const std::string& text) {
  try {
    read_scenario_text(text);
  } catch (const InputError& problem) {
    return problem.what();
  }
  return "no error";
}

std::vector<fs::path> shipped_scenarios() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(SWIFTLET_SOURCE_DIR "/scenarios")) {
    const bool other_kind =
        entry.path().parent_path().filename() == "batch" || entry.path().parent_path().filename() == "dataset";
    if (entry.path().extension() == ".yaml" && !other_kind) files.push_back(entry.path());
  }
  return files;
}

TEST(Scenario, TheDefaultIsValid) {
  const Scenario scenario = validated(Scenario());
  ASSERT_EQ(scenario.vehicles.size(), 1u);
  EXPECT_EQ(scenario.vehicles[0].name, "uav1");
  EXPECT_EQ(scenario.vehicles[0].airframe.num_rotors(), 4);
}

TEST(Scenario, RoundTripsThroughText) {
  const std::string text = write_scenario(validated(Scenario()));
  EXPECT_EQ(write_scenario(read_scenario_text(text)), text);
}

TEST(Scenario, ShippedScenariosAreValidAndUnchanged) {
  const auto files = shipped_scenarios();
  ASSERT_FALSE(files.empty());
  for (const fs::path& file : files) {
    SCOPED_TRACE(file.string());
    try {
      const std::string resolved = write_scenario(load_scenario(file));
      EXPECT_EQ(write_scenario(read_scenario_text(resolved)), resolved);
    } catch (const InputError& problem) {
      ADD_FAILURE() << problem.what();
    }
  }
}

TEST(Scenario, IsFoundByNameToo) {
  const auto assets = list_assets("scenarios");
  ASSERT_FALSE(assets.empty());
  EXPECT_NO_THROW(load_scenario(assets.front().name));
  for (const auto& [name, suggested] :
       {std::pair("forest_patrl.yaml", "\"forest_patrol.yaml\"?"), {"forest_patrl", "\"forest_patrol\"?"}}) {
    try {
      load_scenario(name);
      ADD_FAILURE() << "no error";
    } catch (const InputError& problem) {
      EXPECT_THAT(problem.what(), HasSubstr(std::string("did you mean ") + suggested));
    }
  }
}

TEST(Scenario, ModulesAreValidAndRoundTrip) {
  const auto check = [](std::span<const ModuleType> types, const auto& put) {
    ASSERT_FALSE(types.empty());
    for (const ModuleType& type : types) {
      SCOPED_TRACE(type.name);
      Scenario scenario;
      put(scenario, Module(types, type.name));
      const std::string text = write_scenario(scenario);
      try {
        EXPECT_EQ(write_scenario(read_scenario_text(text)), text);
      } catch (const InputError& problem) {
        // A path that has no sensible default is the one thing that may be missing.
        EXPECT_THAT(problem.what(), HasSubstr("found \"\" by default")) << problem.what();
      }
    }
  };
  check(world_module_types(), [](Scenario& s, Module m) { s.world = std::move(m); });
  check(sensor_module_types(), [](Scenario& s, Module m) { s.vehicles[0].sensors = {std::move(m)}; });
  check(recorder_module_types(), [](Scenario& s, Module m) { s.recorders = {std::move(m)}; });
  check(agent_module_types(), [](Scenario& s, Module m) { s.vehicles[0].agent = std::move(m); });
}

LidarConfig lidar_preset(const std::string& name) {
  const Scenario scenario = read_scenario_text("vehicles: [{sensors: [{type: lidar, model: " + name + "}]}]");
  return dynamic_cast<const LidarConfig&>(*scenario.vehicles.at(0).sensors.at(0).config);
}

TEST(LidarPresets, OustersMatchTheManufacturersRowTable) {
  const LidarConfig os0 = lidar_preset("os0_128"), os1 = lidar_preset("os1_128");
  const OusterConfig& wide = os0.pattern.as<OusterConfig>();
  const OusterConfig& narrow = os1.pattern.as<OusterConfig>();
  ASSERT_EQ(wide.elevations_deg.size(), 128U);
  ASSERT_EQ(wide.azimuths_deg.size(), 128U);
  ASSERT_EQ(narrow.elevations_deg.size(), 128U);
  ASSERT_EQ(narrow.azimuths_deg.size(), 128U);
  EXPECT_NEAR(wide.azimuths_deg[0], 11.24, 1e-9);
  EXPECT_NEAR(wide.azimuths_deg[64], 8.39, 1e-9);
  EXPECT_NEAR(wide.azimuths_deg[127], -11.35, 1e-9);
  EXPECT_NEAR(narrow.azimuths_deg[0], 4.27, 1e-9);
  EXPECT_NEAR(narrow.azimuths_deg[127], -4.3, 1e-9);
  EXPECT_TRUE(std::is_sorted(wide.elevations_deg.rbegin(), wide.elevations_deg.rend()));
  EXPECT_TRUE(std::is_sorted(narrow.elevations_deg.rbegin(), narrow.elevations_deg.rend()));
  EXPECT_NEAR(wide.elevations_deg[63], 0.04, 1e-9);
  EXPECT_NEAR(narrow.elevations_deg[63], 0.05, 1e-9);
}

TEST(LidarPresets, Mid360NeverHitsItsOwnAirframe) {
  for (const char* world : {"forest_team.yaml", "warehouse_team.yaml"}) {
    const Scenario scenario = load_scenario(fs::path(SWIFTLET_SOURCE_DIR "/scenarios/dataset/worlds") / world);
    LidarConfig lidar = dynamic_cast<const LidarConfig&>(*scenario.vehicles.at(1).sensors.at(0).config);
    ASSERT_EQ(lidar.model, "mid360");
    for (const char* model : {"f330", "f450", "x500", "f550", "t650"}) {
      const Scenario drawn = read_scenario_text("vehicles: [{model: " + std::string(model) + "}]");
      SensorSetup setup = sensor_setup("lidar");
      setup.vehicle_shapes = {std::make_shared<VehicleShape>(make_vehicle_shape(drawn.vehicles.at(0).airframe))};
      for (const double pitch_deg : {0.0, 15.0, 25.0}) {
        lidar.mount.rpy_deg.y() = pitch_deg;
        const auto sensor = make_lidar(lidar, setup);
        std::vector<std::shared_ptr<const Scan>> scans;
        drive(*sensor, {resting({0, 0, 50})}, {.duration_s = 0.101},
              [&](TimeNs, const Observation& out) { scans.insert(scans.end(), out.scans.begin(), out.scans.end()); });
        ASSERT_EQ(scans.size(), 1U);
        const auto& masked = scans[0]->beams->masked;
        EXPECT_EQ(std::ranges::count(masked, 1), 0) << model << " " << pitch_deg;
        EXPECT_LT(scans[0]->T_body_lidar.translation().z(), 0.6) << model << " " << pitch_deg;
      }
    }
  }
}

TEST(LidarPresets, ExperimentsKeepTheConstantPublishedNoise) {
  int lidars = 0;
  for (const fs::path& file : shipped_scenarios()) {
    if (file.parent_path().filename() != "reproduce") continue;
    for (const auto& vehicle : load_scenario(file).vehicles) {
      for (const Module& sensor : vehicle.sensors) {
        const auto* const lidar = dynamic_cast<const LidarConfig*>(sensor.config.get());
        if (lidar == nullptr || !lidar->model.starts_with("os")) continue;
        ++lidars;
        EXPECT_EQ(lidar->noise.law, RangeNoiseConfig::Law::kConstant) << file;
        EXPECT_EQ(lidar->noise.sigma_range_m, 0.03) << file;
      }
    }
  }
  EXPECT_GE(lidars, 8);
}

TEST(Scenario, EveryAssetIsValid) {
  for (const Asset& asset : list_assets("vehicles")) {
    EXPECT_EQ(scenario_error("vehicles: [{model: " + asset.name + "}]"), "no error") << asset.name;
    EXPECT_FALSE(asset.doc.empty()) << asset.name;
  }
  for (const Asset& asset : list_assets("sensors")) {
    // A preset belongs to one type: the one that takes it.
    std::string messages;
    bool taken = false;
    for (const ModuleType& type : sensor_module_types()) {
      const std::string message =
          scenario_error("vehicles: [{sensors: [{type: " + std::string(type.name) + ", model: " + asset.name + "}]}]");
      taken = taken || message == "no error";
      messages += message + "\n";
    }
    EXPECT_TRUE(taken) << asset.name << ":\n" << messages;
  }
}

TEST(Scenario, AssetsOfTheUserComeFirst) {
  const TemporaryDirectory folder;
  const fs::path root = folder.path() / "swiftlet_assets_of_the_user";
  fs::create_directories(root / "vehicles");
  std::ofstream(root / "vehicles" / "x500.yaml") << "airframe: {mass_kg: 5}\n";
  std::ofstream(root / "vehicles" / "own_one.yaml") << "# Mine. Really.\nairframe: {mass_kg: 4}\n";
  ASSERT_EQ(setenv("SWIFTLET_ASSETS", ("/nowhere:" + root.string()).c_str(), 1), 0);
  EXPECT_EQ(read_scenario_text("vehicles: [{}]").vehicles[0].airframe.mass_kg, 5.0);
  EXPECT_EQ(read_scenario_text("vehicles: [{model: own_one}]").vehicles[0].airframe.mass_kg, 4.0);
  EXPECT_EQ(read_scenario_text("vehicles: [{model: f450}]").vehicles[0].model, "f450");
  const auto assets = list_assets("vehicles");
  const auto own = std::find_if(assets.begin(), assets.end(), [](const Asset& a) { return a.name == "own_one"; });
  ASSERT_NE(own, assets.end());
  EXPECT_EQ(own->doc, "Mine");
  unsetenv("SWIFTLET_ASSETS");
  fs::remove_all(root);
  EXPECT_NE(read_scenario_text("vehicles: [{}]").vehicles[0].airframe.mass_kg, 5.0);
  EXPECT_THAT(scenario_error("vehicles: [{model: x50}]"), HasSubstr("did you mean \"x500\"?"));
}

TEST(Scenario, RefusesSnapshotsWithoutARenderer) {
  const Scenario scenario = read_scenario_text("duration_s: 2\nsnapshots:\n  - {times_s: [1]}\n");
  for (const Scenario& read : {scenario, validated(scenario)}) {
    std::string problem;
    try {
      require_pictures(read.snapshots_place, "; or fly");
    } catch (const InputError& error) {
      problem = error.what();
    }
    if (picture_library().empty()) {
      EXPECT_THAT(problem, ::testing::StartsWith("flight.yaml:3:3: snapshots: expected a program that draws pictures"));
      EXPECT_THAT(problem, HasSubstr("libegl-dev"));
      EXPECT_THAT(problem, ::testing::EndsWith("; or fly"));
    } else {
      EXPECT_EQ(problem, "");
      EXPECT_EQ(read.snapshots_place, "flight.yaml:3:3: snapshots: ");
    }
  }
}

TEST(Scenario, NamesAreFilledIn) {
  const Scenario scenario = read_scenario_text("vehicles: [{}, {sensors: [imu, imu]}]");
  EXPECT_EQ(scenario.vehicles[0].name, "uav1");
  EXPECT_EQ(scenario.vehicles[1].name, "uav2");
  EXPECT_THAT(write_scenario(scenario), HasSubstr("name: imu2"));
}

std::vector<std::string> names_of(const Scenario& scenario) {
  std::vector<std::string> names;
  for (const VehicleConfig& vehicle : scenario.vehicles) names.push_back(vehicle.name);
  return names;
}

std::vector<Eigen::Vector3d> starts_of(const Scenario& scenario) {
  std::vector<Eigen::Vector3d> starts_m;
  for (const VehicleConfig& vehicle : scenario.vehicles) starts_m.push_back(vehicle.start.position_m);
  return starts_m;
}

TEST(Count, CreatesVehiclesWithNumberedNames) {
  using ::testing::ElementsAre;
  const Scenario scenario =
      read_scenario_text("vehicles: [{count: 2}, {name: eye}, {count: 2}, {name: bird, count: 3, model: f330}]");
  EXPECT_THAT(names_of(scenario), ElementsAre("uav1", "uav2", "eye", "uav4", "uav5", "bird1", "bird2", "bird3"));
  EXPECT_EQ(scenario.vehicles[6].model, "f330");
  EXPECT_THAT(names_of(read_scenario_text("vehicles: [{name: eye, count: 1}, {count: 1}]")),
              ElementsAre("eye", "uav2"));
}

TEST(Count, ArrangesStartsInRowOrGrid) {
  using ::testing::ElementsAre;
  using V = Eigen::Vector3d;
  EXPECT_THAT(starts_of(read_scenario_text("vehicles: [{count: 3}]")), ElementsAre(V(0, 0, 2), V(3, 0, 2), V(6, 0, 2)));
  EXPECT_THAT(
      starts_of(read_scenario_text("vehicles: [{count: 3, start: {position_m: [1, 2 m, 300 cm], spacing_m: [-2, "
                                   "9]}}]")),
      ElementsAre(V(1, 2, 3), V(-1, 2, 3), V(-3, 2, 3)));
  EXPECT_THAT(starts_of(read_scenario_text("vehicles: [{count: 5, start: {spacing_m: [2, 400 cm], columns: 2}}]")),
              ElementsAre(V(0, 0, 2), V(2, 0, 2), V(0, 4, 2), V(2, 4, 2), V(0, 8, 2)));
  EXPECT_THAT(starts_of(read_scenario_text("vehicles: [{count: 2, start: {\"position_m[2]\": 7}}]")),
              ElementsAre(V(0, 0, 7), V(3, 0, 7)));
}

TEST(Count, OverridesVehiclesByNameOrNumber) {
  using ::testing::ElementsAre;
  const std::string text =
      "vehicles: [{name: eye}, {count: 3, name: uav}]\n"
      "vehicles[uav2]: {start: {position_m: [50, 0, 2], yaw_deg: 90}}\n";
  const auto read = [&](const std::vector<std::pair<std::string, std::string>>& changes) {
    Scenario scenario;
    read_config_text(
        text, "flight.yaml", [&](ConfigVisitor& v) { scenario.visit(v); }, changes);
    return scenario;
  };
  const Scenario by_name = read({});
  EXPECT_EQ(by_name.vehicles[2].start.position_m.x(), 50.0) << "as it stands, not moved";
  EXPECT_EQ(by_name.vehicles[2].start.yaw_deg, 90.0);
  EXPECT_EQ(by_name.vehicles[3].start.yaw_deg, 0.0);
  const Scenario changed = read({{"vehicles[3].start.yaw_deg", "45"},
                                 {"vehicles[uav*].airframe.mass_kg", "3"},
                                 {"vehicles[1].count", "4"},
                                 {"vehicles[uav4].start.yaw_deg", "30"}});
  EXPECT_THAT(names_of(changed), ElementsAre("eye", "uav1", "uav2", "uav3", "uav4"));
  EXPECT_EQ(changed.vehicles[3].start.yaw_deg, 45.0) << "numbers are those of the team";
  EXPECT_EQ(changed.vehicles[4].start.yaw_deg, 30.0);
  EXPECT_NE(changed.vehicles[0].airframe.mass_kg, 3.0);
  for (int i = 1; i < 5; ++i) EXPECT_EQ(changed.vehicles[i].airframe.mass_kg, 3.0);
  EXPECT_EQ(read({{"vehicles[uav].count", "7"}}).vehicles.size(), 8U) << "its entry by name";
}

TEST(Count, IsExpandedWhenWrittenOut) {
  const Scenario scenario = read_scenario_text("vehicles: [{count: 4, start: {columns: 2}, sensors: [imu]}]");
  const std::string text = write_scenario(scenario);
  const Scenario again = read_scenario_text(text);
  EXPECT_EQ(write_scenario(again), text);
  EXPECT_EQ(names_of(again), names_of(scenario));
  EXPECT_EQ(starts_of(again), starts_of(scenario));
  Scenario in_code;
  in_code.vehicles[0].count = 3;
  EXPECT_EQ(validated(in_code).vehicles.size(), 3U);
}

TEST(Count, MistakesAreRefusedWithTheirPlace) {
  for (const char* wrong : {"0", "-1", "2.5", "many", "10001", "[3]"}) {
    EXPECT_THAT(scenario_error("vehicles: [{count: " + std::string(wrong) + "}]"),
                ::testing::StartsWith("flight.yaml:1:20: vehicles[0].count: expected a whole number in [1, 10000]"))
        << wrong;
  }
  EXPECT_THAT(scenario_error("vehicles: [{cuont: 3}]"), HasSubstr("did you mean \"count\"?"));
  const std::string once = scenario_error("vehicles:\n  - {count: 3, sped: 1}\n");
  EXPECT_EQ(std::count(once.begin(), once.end(), '\n'), 0) << once;
  EXPECT_THAT(
      scenario_error("vehicles: [{count: 3}]\nvehicles[uva3]: {model: f450}\n"),
      HasSubstr("flight.yaml:2:1: vehicles[uva3]: expected an index below 3, the name of an element or *, found "
                "\"uva3\"; did you mean \"uav3\"?"));
  EXPECT_THAT(scenario_error("vehicles: [{count: 2, name: a}, {name: a2}]"),
              HasSubstr("vehicles[2].name: expected a name that is not taken yet"));
  std::string large = "vehicles: [{count: 10000, sensors: [";
  for (int i = 0; i < 200; ++i) large += "imu, ";
  EXPECT_THAT(scenario_error(large + "]}]"), HasSubstr("expected at most 1000000 values in all vehicles, found more"));
}

TEST(Scenario, WritesTruthByNameAsSensor) {
  const Scenario scenario = read_scenario_text(
      "vehicles: [{agent: {detector: ground_truth}}, {sensors: [{type: pose, name: mocap}]}, {agent: {type: none}}]");
  EXPECT_TRUE(scenario.vehicles[0].sensors.empty());
  const Scenario resolved = read_scenario_text(write_scenario(scenario));
  ASSERT_EQ(resolved.vehicles[0].sensors.size(), 2U);
  EXPECT_EQ(resolved.vehicles[0].sensors[0].type, "pose");
  EXPECT_EQ(resolved.vehicles[0].sensors[1].type, "neighbors");
  EXPECT_TRUE(resolved.vehicles[0].sensors[1].as<NeighborsConfig>().ideal);
  EXPECT_EQ(resolved.vehicles[1].sensors.size(), 1U) << "the configured pose sensor alone";
  EXPECT_TRUE(resolved.vehicles[2].sensors.empty()) << "an agent of type none needs no sensor";
}

TEST(Scenario, NamesAreUniqueAndFileSafe) {
  EXPECT_EQ(scenario_error("vehicles:\n  - name: a\n  - name: a\n"),
            "flight.yaml:3:11: vehicles[1].name: expected a name that is not taken yet, found \"a\"");
  EXPECT_THAT(scenario_error("vehicles: [{name: uav2}, {}]"),
              HasSubstr("vehicles[1].name: expected a name that is not taken yet"));
  EXPECT_THAT(scenario_error("vehicles: [{name: ../a}]"),
              HasSubstr("flight.yaml:1:19: vehicles[0].name: expected a name of letters"));
  EXPECT_THAT(scenario_error("vehicles: [{sensors: [{type: imu, name: a}, {type: gnss, name: a}]}]"),
              HasSubstr("vehicles[0].sensors[1].name: expected a name that is not taken yet, found \"a\""));
  EXPECT_EQ(scenario_error("vehicles: [{sensors: [{type: imu, name: a}]}, {sensors: [{type: imu, name: a}]}]"),
            "no error");
  EXPECT_THAT(scenario_error("snapshots: [{name: a, times_s: [1]}, {name: a, times_s: [1]}]"),
              HasSubstr("snapshots[1].name: expected a name that is not taken yet"));
  EXPECT_THAT(scenario_error("name: a/b"), HasSubstr("name: expected a name of letters"));
  EXPECT_THAT(scenario_error("name: .."), HasSubstr("name: expected a name of letters"));
}

TEST(Scenario, ValidatesSnapshotTimesSizesAndOverlays) {
  EXPECT_EQ(scenario_error("snapshots: [{name: a}]"),
            "flight.yaml:1:13: snapshots[0].times_s: expected times of pictures, here or by every_s");
  EXPECT_EQ(scenario_error("snapshots: [{times_s: [1], style: paper, width_mm: 85, height_mm: 60}]"), "no error");
  EXPECT_EQ(scenario_error("snapshots: [{times_s: [1], width_mm: 85}]"),
            "flight.yaml:1:38: snapshots[0].width_mm: expected style paper: a screen has no millimeters, found "
            "\"85\"");
  EXPECT_THAT(scenario_error("snapshots: [{times_s: [1], style: paper, height_mm: 600, dpi: 600}]"),
              HasSubstr("snapshots[0].height_mm: expected a picture of 64 to 8192 px a side at the dpi given"));
  EXPECT_EQ(scenario_error("snapshots: [{times_s: [1], overlays: [tracks, trackz]}]"),
            "flight.yaml:1:47: snapshots[0].overlays[1]: expected what an agent draws (swiftlet list overlays), found "
            "\"trackz\"; did you mean \"tracks\"?");
  EXPECT_EQ(scenario_error("snapshots: [{times_s: [1], overlays: ['*', uav1/rbl.cell, guide.visible]}]"), "no error")
      << "an overlay of another type of stage is no mistake: stages change more often than cameras";
  EXPECT_THAT(scenario_error("snapshots: [{times_s: [1], overlays: [uav7/rbl.cell]}]"), HasSubstr("\"uav1/rbl.cell\""));
}

TEST(Scenario, CamerasReferToExistingTargets) {
  EXPECT_EQ(scenario_error("vehicles: [{name: alpha}]\nsnapshots: [{type: follow, vehicle: alhpa, times_s: [1]}]"),
            "flight.yaml:2:37: snapshots[0].vehicle: expected \"alpha\", found \"alhpa\"; did you mean \"alpha\"?");
  EXPECT_THAT(scenario_error("vehicles: [{sensors: [{type: lidar, name: os1}]}]\nsnapshots: [{type: lidar_range, "
                             "sensor: os2, every_s: 1}]"),
              HasSubstr("snapshots[0].sensor: expected \"os1\", found \"os2\"; did you mean \"os1\"?"));
  EXPECT_EQ(scenario_error("vehicles: [{sensors: [{type: lidar, name: os1}]}]\nsnapshots: [{type: lidar_range, sensor: "
                           "os1, every_s: 1}]"),
            "no error");
}

TEST(Scenario, TickIsMultipleOfPhysicsStep) {
  EXPECT_EQ(scenario_error("tick_s: 4 ms\nphysics: {step_s: 1 ms}"), "no error");
  EXPECT_EQ(scenario_error("tick_s: 4.5 ms\nphysics: {step_s: 1 ms}"),
            "flight.yaml:1:9: tick_s: expected a whole multiple of physics.step_s, found \"4.5 ms\"");
  EXPECT_THAT(scenario_error("tick_s: 1 ms\nphysics: {step_s: 2 ms}"), HasSubstr("whole multiple"));
  EXPECT_THAT(scenario_error("tick_s: 0"), HasSubstr("tick_s: expected a number in (0, 1]"));
  EXPECT_THAT(scenario_error("duration_s: 0"), HasSubstr("duration_s: expected a number in (0, 1"));
  EXPECT_THAT(scenario_error("duration_s: 1 ms"), HasSubstr("duration_s: expected at least one tick_s"));
}

TEST(Scenario, OverridesReachEveryDepth) {
  const std::string file = SWIFTLET_SOURCE_DIR "/scenarios/forest_patrol.yaml";
  const Scenario scenario = load_scenario(
      file, {{"vehicles[0].start.yaw_deg", "90"}, {"vehicles[*].airframe.mass_kg", "1500 g"}, {"seed", "5"}});
  EXPECT_EQ(scenario.seed, 5u);
  EXPECT_EQ(scenario.vehicles[0].start.yaw_deg, 90.0);
  for (const VehicleConfig& vehicle : scenario.vehicles) EXPECT_EQ(vehicle.airframe.mass_kg, 1.5);
  EXPECT_THROW(load_scenario(file, {{"vehicles[0].start.yaw", "90"}}), InputError);
}

TEST(Scenario, RecordersStayInsideTheRunDirectory) {
  for (const std::string place : {"../out", "a/../../b", "/tmp/x", "", "a//b", "a/", ".", "..", ".hidden", "-o",
                                  "a\\nb", "summary.json", "scenario.yaml", "summary.json/a", "x.part"}) {
    for (const auto& [type, key] :
         {std::pair{"mcap", "file"}, {"rosbag", "file"}, {"pcd", "folder"}, {"ply", "folder"}}) {
      const std::string error =
          scenario_error(std::string("recorders:\n  - {type: ") + type + ", " + key + ": \"" + place + "\"}\n");
      EXPECT_THAT(error, HasSubstr("flight.yaml:2:")) << type << " " << place;
      EXPECT_THAT(error, HasSubstr(std::string("recorders[0].") + key)) << type << " " << place;
    }
  }
  EXPECT_EQ(scenario_error("recorders: [{type: mcap, file: logs/a.mcap}, {type: pcd, folder: logs/scans}]"),
            "no error");
}

TEST(Scenario, NoTwoRecordersWriteTheSame) {
  for (const std::string recorders :
       {"{type: mcap, file: a}, {type: rosbag, file: a}", "{type: pcd, folder: a}, {type: pcd, folder: a}",
        "{type: pcd, folder: a}, {type: mcap, file: a}", "{type: mcap, file: a}, {type: ply, folder: a/b}",
        "{type: pcd, folder: x, vehicles: [a, b]}, {type: pcd, folder: x, vehicles: [b]}", "{type: tum}, {type: tum}",
        "{type: csv}, {type: csv}", "{type: events}, {type: mcap, file: events.jsonl}"}) {
    EXPECT_THAT(scenario_error("vehicles: [{name: a}, {name: b}]\nrecorders: [" + recorders + "]"),
                HasSubstr("recorders[1]."))
        << recorders;
  }
  for (const std::string recorders :
       {"{type: pcd}, {type: ply}", "{type: pcd, vehicles: [a]}, {type: pcd, vehicles: [b]}",
        "{type: pcd, sensors: [front]}, {type: pcd, sensors: [rear]}", "{type: pcd, folder: a}, {type: pcd, folder: b}",
        "{type: csv, topics: [state]}, {type: csv, topics: [imu]}"}) {
    EXPECT_EQ(scenario_error("vehicles: [{name: a}, {name: b}]\nrecorders: [" + recorders + "]"), "no error")
        << recorders;
  }
}

TEST(Scenario, ReportsRecorderOfMissingVehicle) {
  EXPECT_THAT(scenario_error("vehicles: [{name: alpha}]\nrecorders: [{type: tum, vehicles: [alpha, alfa]}]"),
              HasSubstr("flight.yaml:2:43: recorders[0].vehicles[1]: expected \"alpha\""));
}

TEST(Scenario, RefusesAmbiguousRosNamesWhenRecorded) {
  const std::string ros = "\nrecorders: [{type: mcap}]";
  const std::string team = "vehicles: [{name: uav-1}, {name: uav2}, {name: uav_1}]";
  EXPECT_EQ(scenario_error(team + ros),
            "flight.yaml:1:48: vehicles[2].name: expected a name that differs from uav-1 in ROS topics, where both are "
            "uav_1, found \"uav_1\"");
  EXPECT_THAT(scenario_error(team + "\nrecorders: [{type: tum}, {type: rosbag}]"), HasSubstr("vehicles[2].name"));
  EXPECT_EQ(scenario_error(team + "\nrecorders: [{type: tum}, {type: csv}]"), "no error");
  EXPECT_EQ(scenario_error(team + "\nrecorders: [{type: mcap, vehicles: [uav_1, uav2]}]"), "no error");
  EXPECT_EQ(scenario_error("vehicles: [{name: \"1\"}]" + ros),
            "flight.yaml:1:19: vehicles[0].name: expected a name that begins with a letter, because a recorder writes "
            "ROS topics, found \"1\"");
  EXPECT_THAT(scenario_error("vehicles: [{name: \"4x\", count: 2}]" + ros), HasSubstr("vehicles[0].name"));
  EXPECT_EQ(scenario_error("vehicles: [{name: \"1\"}]"), "no error");

  const auto lidars = [&](const std::string& a, const std::string& b) {
    return scenario_error("vehicles: [{sensors: [{type: lidar, name: " + a + "}, {type: lidar, name: " + b + "}]}]" +
                          ros);
  };
  EXPECT_EQ(lidars("os1", "os-1"), "no error");
  EXPECT_THAT(lidars("os.1", "os-1"), HasSubstr("vehicles[0].sensors[1].name: expected a name that differs from os.1"));
  EXPECT_THAT(lidars("\"3d\"", "b"),
              HasSubstr("vehicles[0].sensors[0].name: expected a name that begins with a letter"));
  EXPECT_THAT(lidars("os1", "body"), HasSubstr("vehicles[0].sensors[1].name: expected a name that differs from body"));
  EXPECT_EQ(scenario_error("vehicles: [{sensors: [{type: imu, name: body}]}]" + ros), "no error");
}

TEST(Scenario, TwoLidarsNeverShareScanFolders) {
  const std::string team =
      "vehicles: [{name: a, sensors: [{type: lidar, name: b_c}]}, {name: a_b, sensors: [{type: lidar, name: c}]}]\n";
  EXPECT_THAT(
      scenario_error(team + "recorders: [{type: ply}]"),
      HasSubstr(
          "vehicles[1].sensors[0].name: expected a name whose folder of scans no other LiDAR has; a_b_c is taken"));
  EXPECT_EQ(scenario_error(team + "recorders: [{type: ply, vehicles: [a]}, {type: pcd, vehicles: [a_b]}]"), "no error");
}

TEST(Scenario, RefusesMassesOutsideTheRotorRange) {
  // Four rotors of 16.48 N carry 6.109 kg with a tenth to spare; at their least speed they carry 0.151 kg.
  const auto with_mass = [](const std::string& mass_kg, const std::string& agent = "stack") {
    return scenario_error("vehicles:\n  - {model: x500, agent: {type: " + agent + "}, airframe: {mass_kg: " + mass_kg +
                          "}}\n");
  };
  EXPECT_THAT(with_mass("8"), HasSubstr("flight.yaml:2:61: vehicles[0].airframe.mass_kg: expected at most 6.1"));
  EXPECT_THAT(with_mass("8"), HasSubstr("1.1 times its weight, found \"8\""));
  EXPECT_NE(with_mass("6.12"), "no error");
  EXPECT_EQ(with_mass("6.1"), "no error");
  EXPECT_THAT(with_mass("0.15"), HasSubstr("vehicles[0].airframe.mass_kg: expected at least 0.152 kg"));
  EXPECT_EQ(with_mass("0.152"), "no error");
  EXPECT_EQ(with_mass("8", "none"), "no error") << "a dummy need not fly";
  EXPECT_THAT(scenario_error("vehicles: [{airframe: {rotor_speed_max_radps: 300}}]"),
              HasSubstr("vehicles[0].airframe.mass_kg"));
}

TEST(Scenario, RefusesAPhysicallyImpossibleInertia) {
  const auto with = [](const std::string& inertia) {
    return scenario_error("vehicles: [{airframe: {inertia_diagonal_kgm2: " + inertia + "}}]");
  };
  for (const char* bad :
       {"[0.02, 0.02, 0.05]", "[0.05, 0.02, 0.02]", "[0.02, 0.0001, 0.03]", "[0.02, 0, 0.02]", "[0.02, -0.02, 0.02]"}) {
    EXPECT_THAT(with(bad), HasSubstr("vehicles[0].airframe.inertia_diagonal_kgm2")) << bad;
    EXPECT_THAT(with(bad), HasSubstr("flight.yaml:1:")) << bad;
  }
  for (const char* good : {"[0.02, 0.02, 0.04]", "[0.02, 0.03, 0.045]", "[0.01, 0.01, 0.01]"})
    EXPECT_EQ(with(good), "no error") << good << ": a flat plate, three axes, a ball";
}

TEST(Scenario, RefusesUnreasonableValuesWithTheirPlace) {
  const auto detector = [](const std::string& keys) {
    return "vehicles: [{agent: {detector: {type: vofod, " + keys + "}}}]";
  };
  const std::pair<std::string, std::string> cases[] = {
      {"wind: {mean_mps: -1e30}", "wind.mean_mps"},
      {"physics: {contact_friction: 1e200}", "physics.contact_friction"},
      {"wind: {mean_mps: [1e200, 0, 0]}", "wind.mean_mps"},
      {"wind: {wind_at_6m_mps: 1e10}", "wind.wind_at_6m_mps"},
      {"vehicles: [{start: {velocity_mps: [0, 1e99, 0]}}]", "vehicles[0].start.velocity_mps"},
      {"vehicles: [{start: {position_m: [1e18, 0, 5]}}]", "vehicles[0].start.position_m"},
      {"vehicles: [{airframe: {mass_kg: 1e-300}}]", "vehicles[0].airframe.mass_kg"},
      {"vehicles: [{sensors: [{type: imu, rate_hz: 3e9}]}]", "vehicles[0].sensors[0].rate_hz"},
      {"vehicles: [{sensors: [{type: pose, rate_hz: 1e-12}]}]", "vehicles[0].sensors[0].rate_hz"},
      {"vehicles: [{agent: {mapping: {type: occupancy, clear_range_m: 1e9}}}]", "clear_range_m"},
      {detector("ray_max_m: 1e6"), "vehicles[0].agent.detector.ray_max_m"},
      {detector("ray_max_m: 900, map: {size_m: [700, 700, 120]}"), "vehicles[0].agent.detector.ray_max_m"},
      {detector("map: {center_m: [1e18, 0, 0], extent: bounded}"), "vehicles[0].agent.detector.map.center_m"},
      {detector("map: {voxel_m: 1e-9}"), "vehicles[0].agent.detector.map.voxel_m"},
      {detector("close_distance_m: 1e18"), "vehicles[0].agent.detector.close_distance_m"},
      {detector("close_distance_m: 90"), "vehicles[0].agent.detector.close_distance_m"},
      {"vehicles: [{agent: {guidance: {type: hover, point_m: [1e10, 0, 0]}}}]", "guidance.point_m"},
  };
  for (const auto& [text, key] : cases) {
    EXPECT_THAT(scenario_error(text), HasSubstr("flight.yaml:1:")) << text;
    EXPECT_THAT(scenario_error(text), HasSubstr(key)) << text;
  }
}

/// Every scenario with one module of a registry and defaults else, as text.
std::vector<std::string> texts_of_all_modules() {
  std::vector<std::string> texts;
  const auto add = [&](std::span<const ModuleType> types, const auto& put) {
    for (const ModuleType& type : types) {
      Scenario scenario;
      put(scenario, Module(types, type.name));
      texts.push_back(write_scenario(scenario));
    }
  };
  const auto stack = [](Scenario& s) -> StackConfig& { return s.vehicles[0].agent.as<StackConfig>(); };
  add(world_module_types(), [](Scenario& s, Module m) { s.world = std::move(m); });
  add(sensor_module_types(), [](Scenario& s, Module m) { s.vehicles[0].sensors = {std::move(m)}; });
  add(recorder_module_types(), [](Scenario& s, Module m) { s.recorders = {std::move(m)}; });
  add(estimator_module_types(), [&](Scenario& s, Module m) { stack(s).localization = std::move(m); });
  add(detector_module_types(), [&](Scenario& s, Module m) { stack(s).detector = std::move(m); });
  add(tracker_module_types(), [&](Scenario& s, Module m) { stack(s).tracker = std::move(m); });
  add(mapper_module_types(), [&](Scenario& s, Module m) { stack(s).mapping = std::move(m); });
  add(guidance_module_types(), [&](Scenario& s, Module m) { stack(s).guidance = std::move(m); });
  return texts;
}

TEST(Scenario, LoadsOrRefusesEveryAbsurdNumber) {
  std::set<std::string> seen;  // lines: most keys stand in every text
  std::size_t tried = 0;
  for (const std::string& text : texts_of_all_modules()) {
    std::size_t begin = 0;
    for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
      const std::string line = text.substr(begin, end - begin);
      const std::size_t colon = line.find(": ");
      if (colon == std::string::npos || line.find_first_of("0123456789", colon) == std::string::npos) continue;
      if (line[colon + 2] == '"' || line.find_first_not_of("-+.e0123456789[], ", colon + 2) != std::string::npos)
        continue;
      if (!seen.insert(line).second) continue;
      const std::size_t first = line.find_first_of("-.0123456789", colon + 2);
      const std::size_t last = std::min(line.find_first_of(",]", first), line.size());
      for (const char* value : {"1e18", "-1e300"}) {
        const std::string changed =
            text.substr(0, begin) + line.substr(0, first) + value + line.substr(last) + text.substr(end);
        const std::string error = scenario_error(changed);
        ++tried;
        if (error == "no error") {
          EXPECT_EQ(std::string(value).find("1e300"), std::string::npos) << line << " took " << value;
        } else if (!error.starts_with("flight.yaml:")) {
          // Paths without a sensible default are missing anyway.
          EXPECT_THAT(error, HasSubstr("by default")) << line << " with " << value;
        }
      }
    }
  }
  EXPECT_GT(tried, 500U);
}

}  // namespace
}  // namespace swiftlet::sim
