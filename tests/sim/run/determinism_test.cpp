// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <clocale>
#include <filesystem>
#include <locale>
#include <map>

#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/octomap/octomap_file.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/world/export.hpp"
#include "swiftlet/sim/world/point_cloud_file.hpp"
#include "tests/support/recorder_types.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

const std::string kMixedTeam = SWIFTLET_SOURCE_DIR "/tests/golden/mixed_team.yaml";

std::uint64_t fly(Scenario scenario, int threads, const std::string& recordings = {}) {
  Simulation simulation(std::move(scenario), threads);
  if (!recordings.empty()) simulation.attach_recorders(recordings);
  while (!simulation.finished()) simulation.tick();
  simulation.finish();
  return simulation.state_hash();
}

std::uint64_t reference_hash() {
  static const std::uint64_t hash = fly(load_scenario(kMixedTeam), 1);
  return hash;
}

// Sanitizers make no difference to the bits, but a minute of difference to the time.
TEST(Determinism, ThreadsDoNotChangeTheBits) {
  for (const int threads : {2, 4})
    EXPECT_EQ(fly(load_scenario(kMixedTeam), threads), reference_hash()) << threads << " threads";
}

// Large crowds are flown by several threads. Two vehicles fall onto others, the rest stay clear.
TEST(Determinism, CrowdIsIndependentOfThreadCount) {
  Scenario scenario = load_scenario("bench_crowd", {{"duration_s", "1.5"}});
  const VehicleConfig model = scenario.vehicles.front();
  scenario.vehicles.clear();
  for (int i = 0; i < 24; ++i) {
    VehicleConfig vehicle = model;
    vehicle.name = "uav" + std::to_string(i + 1);
    vehicle.start.position_m += Eigen::Vector3d(1.5 * (i % 6), 1.5 * (i / 6), i % 3);
    if (i < 2) {  // motors at idle, 4 m above others
      vehicle.agent = Module(agent_module_types(), "none");
      vehicle.start.position_m += Eigen::Vector3d(0.0, 3.0, 4.0);
    }
    scenario.vehicles.push_back(std::move(vehicle));
  }
  Simulation alone(scenario, 1);
  while (!alone.finished()) alone.tick();
  const std::uint64_t hash = alone.state_hash();
  EXPECT_EQ(alone.summary().outcome, "crashed");
  for (const int threads : {2, 3}) EXPECT_EQ(fly(scenario, threads), hash) << threads << " threads";
}

TEST(Determinism, AnotherSeedGivesAnotherRun) {
  EXPECT_NE(fly(load_scenario(kMixedTeam, {{"seed", "12"}}), 2), reference_hash());
}

TEST(Determinism, ResolvedScenarioReproducesTheRun) {
  const TemporaryDirectory folder;
  const std::string path = folder.path() / "resolved.yaml";
  write_file(path, write_scenario(load_scenario(kMixedTeam)));
  const Scenario resolved = load_scenario(path);
  EXPECT_EQ(write_scenario(resolved), write_scenario(load_scenario(kMixedTeam)));
  EXPECT_EQ(fly(resolved, 2), reference_hash());
}

TEST(Determinism, IsUnaffectedByRecordersAndPictures) {
  Scenario scenario = load_scenario(kMixedTeam);
  for (const char* type : recorders_of_any_run()) scenario.recorders.emplace_back(recorder_module_types(), type);
  CameraConfig camera;
  camera.times_s = {0.5};
  camera.width_px = 160;
  camera.height_px = 90;
  scenario.snapshots = {camera};
  const TemporaryDirectory folder;
  EXPECT_EQ(fly(scenario, 2, folder.path()), reference_hash());
}

/// The global locale of a host program: commas in numbers, and points between thousands.
class GermanProgram {
 public:
  GermanProgram() {
    for (const char* name : {"de_DE.UTF-8", "de_DE", "fr_FR.UTF-8", "cs_CZ.UTF-8"}) {
      if (std::setlocale(LC_NUMERIC, name) != nullptr) break;  // the C library's locale too, where installed
    }
    before_ = std::locale::global(std::locale(std::locale::classic(), new Numbers));
  }
  ~GermanProgram() {
    std::locale::global(before_);
    std::setlocale(LC_NUMERIC, "C");
  }
  GermanProgram(const GermanProgram&) = delete;
  GermanProgram& operator=(const GermanProgram&) = delete;

 private:
  struct Numbers : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  std::locale before_;
};

std::map<std::string, std::string> files_of(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files[entry.path().lexically_relative(folder)] = read_whole_file(entry.path());
  }
  return files;
}

TEST(Determinism, FilesAreIndependentOfLocale) {
  const auto fly_both = [](const std::filesystem::path& folder) {
    Scenario mixed = load_scenario(kMixedTeam, {{"duration_s", "0.15"}});
    for (const char* type : recorders_of_any_run()) mixed.recorders.emplace_back(recorder_module_types(), type);
    std::filesystem::create_directories(folder / "mixed");
    fly(mixed, 1, folder / "mixed");
    std::filesystem::create_directories(folder / "maps");
    fly(load_scenario("submap_navigation", {{"duration_s", "0.4"}, {"snapshots", "[]"}}), 1, folder / "maps");
    write_file(folder / "mixed.yaml", write_scenario(mixed));
    export_world(make_world(mixed.world, 1), folder / "world.ply");
    export_world(make_world(mixed.world, 1), folder / "world.obj");
  };
  const TemporaryDirectory plain, german;
  fly_both(plain.path());
  std::size_t num_points = 0, num_cells = 0;
  {
    const GermanProgram program;
    fly_both(german.path());
    for (const auto& [name, content] : files_of(german.path())) {
      if (name.ends_with(".pcd") || (name.ends_with(".ply") && name.starts_with("mixed")))
        num_points += read_point_cloud(german.path() / name).size();
      if (name.ends_with(".bt")) num_cells += read_octomap(german.path() / name).occupied_m.size();
    }
  }
  const auto expected = files_of(plain.path()), found = files_of(german.path());
  ASSERT_EQ(expected.size(), found.size());
  for (const auto& [name, content] : expected) EXPECT_TRUE(found.at(name) == content) << name;
  EXPECT_GT(num_points, 1000U) << "read in that locale too";
  EXPECT_GT(num_cells, 1000U);
}

TEST(Determinism, SharedWorldReproducesTheRun) {
  const Scenario scenario = load_scenario(kMixedTeam);
  const World world = build_world(scenario.world, scenario.seed);
  for (int run = 0; run < 2; ++run) {
    Simulation simulation(scenario, 2, world);
    while (!simulation.finished()) simulation.tick();
    EXPECT_EQ(simulation.state_hash(), reference_hash()) << "run " << run;
  }
}

// Adding a sensor to one vehicle changes no other vehicle's numbers.
TEST(Determinism, AnotherSensorChangesNoOtherNumbers) {
  Scenario scenario = load_scenario(kMixedTeam, {{"duration_s", "0.3"}});
  Simulation plain(scenario, 2);
  scenario.vehicles[0].sensors.insert(scenario.vehicles[0].sensors.begin(), Module(sensor_module_types(), "gnss"));
  Simulation with_gnss(scenario, 2);
  while (!plain.finished()) {
    plain.tick();
    with_gnss.tick();
    for (int i = 0; i < 4; ++i) {
      const auto& a = plain.view().observations[i];
      const auto& b = with_gnss.view().observations[i];
      ASSERT_EQ(a.imu.size(), b.imu.size());
      for (std::size_t k = 0; k < a.imu.size(); ++k) ASSERT_EQ(a.imu[k].omega_body_radps, b.imu[k].omega_body_radps);
      ASSERT_EQ(a.scans.size(), b.scans.size());
      for (std::size_t k = 0; k < a.scans.size(); ++k) ASSERT_EQ(a.scans[k]->range_m, b.scans[k]->range_m);
    }
  }
}

}  // namespace
}  // namespace swiftlet::sim
