// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/slam_map/slam_map_file.hpp"
#include "swiftlet/sim/slam_map/slam_map_recorder.hpp"
#include "tests/support/fnv.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

/// Tests run beside each other.
std::filesystem::path temporary(const std::string& name) {
  const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  return std::filesystem::path(::testing::TempDir()) / ("swiftlet_" + test + "_" + name + ".slam");
}

/// A little of everything.
SavedMap small_map() {
  SavedMap map;
  map.voxel_m = 0.1;
  map.graph.add_pose(make_pose({1, 2, 3}, Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5)));
  map.graph.add_pose(make_pose({-1.0 / 3.0, 2e-9, 3e7}, Eigen::Quaterniond::Identity()));
  map.graph.add_pose(make_pose({4, 5, 6}, Eigen::Quaterniond::Identity()));
  Matrix6 information = Matrix6::Identity();
  information(2, 4) = 0.1;
  map.graph.add(RelativeFactor{0, 1, make_pose({0, 0, 1}, Eigen::Quaterniond::Identity()), information, kNoHuber});
  map.graph.add(RelativeFactor{2, 0, Pose::Identity(), information, 3.0});
  map.graph.add(PriorFactor{0, map.graph.pose(0), information});
  map.graph.add(GravityFactor{1, Vector3::UnitZ(), 0.01});
  map.graph.add(PositionFactor{0, 1, 0.25, {7, 8, 9}, {1, 1, 0.1}, 1.0});
  map.nodes = {{-5, 0}, {1'000'000'000, 1}};
  map.submaps = {{2, {{1.5F, 0.1F, -2.0F}, {3.0F, 4.0F, 5.0F}}}, {1, {}}};
  CellBlock both{{-3, 4, 5}, {}, {}}, free{{7, -8, 9}, {}, {}};
  both.occupied[2] = 0x8000000000000001ULL;
  both.free[2] = 0x0F0ULL;
  free.free[7] = 1;
  const CellBlock blocks[] = {both, free};
  map.pieces = {{0, make_pose({0.5, 0, 0}, Eigen::Quaterniond(0.5, 0.5, 0.5, -0.5)),
                 std::make_shared<const SubmapCells>(0.25, blocks)}};
  return map;
}

std::string refusal_of(const std::string& content, const std::string& name) {
  write_file(temporary(name), content);
  try {
    read_slam_map(temporary(name));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SlamMapFile, RoundTripsBitForBit) {
  const SavedMap map = small_map();
  const std::string content = slam_map_content(map);
  write_file(temporary("round"), content);
  const SavedMap again = read_slam_map(temporary("round"));
  EXPECT_EQ(slam_map_content(again), content);
  ASSERT_EQ(again.graph.num_poses(), 3);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(again.graph.pose(i).matrix(), map.graph.pose(i).matrix());
  EXPECT_EQ(again.graph.cost(), map.graph.cost());
  ASSERT_EQ(again.graph.relative_factors().size(), 2U);
  EXPECT_EQ(again.graph.relative_factors()[0].huber, kNoHuber);
  EXPECT_EQ(again.graph.relative_factors()[1].information, map.graph.relative_factors()[1].information);
  EXPECT_EQ(again.nodes[0].t, -5);
  EXPECT_EQ(again.submaps[0].points_submap_m, map.submaps[0].points_submap_m);
  EXPECT_EQ(again.submaps[1].pose, 1);
  ASSERT_EQ(again.pieces.size(), 1U);
  EXPECT_EQ(again.pieces[0].T_submap_cells.matrix(), map.pieces[0].T_submap_cells.matrix());
  const SubmapCells& cells = *again.pieces[0].cells;
  EXPECT_EQ(cells.edge_m(), 0.25);
  ASSERT_EQ(cells.num_blocks(), 2U);
  const int i = cells.find({-3, 4, 5});
  ASSERT_GE(i, 0);
  ASSERT_NE(cells.occupied_of(i), nullptr);
  EXPECT_EQ((*cells.occupied_of(i))[2], 0x8000000000000001ULL);
  EXPECT_EQ(cells.free_of(i)[2], 0x0F0ULL);
  EXPECT_EQ(cells.occupied_of(cells.find({7, -8, 9})), nullptr);
}

TEST(SlamMapFile, DamageAnywhereIsNoticed) {
  const std::string content = slam_map_content(small_map());
  for (std::size_t i = 0; i < content.size(); i += i < 48 ? 1 : 11) {
    std::string damaged = content;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    EXPECT_NE(refusal_of(damaged, "damaged"), "") << "byte " << i;
  }
  for (const std::size_t size : {std::size_t{0}, std::size_t{10}, content.size() / 2, content.size() - 1}) {
    EXPECT_NE(refusal_of(content.substr(0, size), "cut"), "") << size << " bytes";
  }
  EXPECT_NE(refusal_of(content + "x", "longer"), "");
  EXPECT_NE(refusal_of(content.substr(0, content.size() - 4), "cut").find("is damaged: expected"), std::string::npos);
}

TEST(SlamMapFile, RefusesOtherVersionsByNumber) {
  std::string content = slam_map_content(small_map());
  content[content.find('\n') + 1] = 1;
  const std::string refusal = refusal_of(content, "version");
  EXPECT_NE(refusal.find("expected version 2 of such maps, found version 1"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find(temporary("version").string()), std::string::npos) << refusal;
}

TEST(SlamMapFile, WhatIsNoMapIsRefused) {
  EXPECT_NE(refusal_of("ply\nformat ascii 1.0\n", "ply").find("begins with its title"), std::string::npos);
  SavedMap map = small_map();
  map.submaps[0].pose = 17;
  EXPECT_NE(refusal_of(slam_map_content(map), "pose").find("is damaged: a submap has no pose"), std::string::npos);
  map = small_map();
  map.pieces[0].submap = 2;
  EXPECT_NE(refusal_of(slam_map_content(map), "piece").find("is damaged: cells belong to no submap"),
            std::string::npos);
}

/// Version 2: title, version, size, checksum; then numbers as in memory.
class Bytes {
 public:
  template <class Number>
  Bytes& put(Number number) {
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof number);
    return *this;
  }
  Bytes& put_all(std::initializer_list<double> numbers) {
    for (const double number : numbers) put(number);
    return *this;
  }
  Bytes& pose() { return put_all({1, 0, 0, 0, 1, 0, 0, 0, 1, 4, 5, 6}); }
  Bytes& identity() {
    for (int i = 0; i < 36; ++i) put(i % 7 == 0 ? 1.0 : 0.0);
    return *this;
  }
  const std::string& text() const { return bytes_; }
  std::string file() const {
    test::Fnv1a hash;
    hash.add(bytes_.data(), bytes_.size());
    Bytes head;
    head.put(std::uint32_t{2}).put(static_cast<std::uint64_t>(bytes_.size())).put(hash.value());
    return "Swiftlet map of SLAM\n" + head.text() + bytes_;
  }

 private:
  std::string bytes_;
};

using Count = std::uint64_t;

/// Two poses; then what a test adds of each kind of factor, a node and a submap, and no cells.
std::string file_of(const Bytes& factors) {
  Bytes bytes;
  bytes.put(0.1).put(Count{2}).pose().pose();
  std::string payload = bytes.text() + factors.text();
  Bytes rest;
  rest.put(Count{1}).put(std::int64_t{7}).put(std::int32_t{1});
  rest.put(Count{1}).put(std::int32_t{0}).put(Count{1}).put(1.0F).put(2.0F).put(3.0F);
  rest.put(Count{0});
  payload += rest.text();
  Bytes all;
  for (const char c : payload) all.put(c);
  return all.file();
}

TEST(SlamMapFile, MatchesItsVersionByteForByte) {
  Bytes none;
  none.put(Count{0}).put(Count{0}).put(Count{0}).put(Count{0});
  write_file(temporary("own"), file_of(none));
  const SavedMap map = read_slam_map(temporary("own"));
  EXPECT_EQ(map.voxel_m, 0.1);
  ASSERT_EQ(map.graph.num_poses(), 2);
  EXPECT_EQ(map.graph.pose(1).translation(), Vector3(4, 5, 6));
  ASSERT_EQ(map.nodes.size(), 1U);
  EXPECT_EQ(map.nodes[0].t, 7);
  EXPECT_EQ(map.nodes[0].pose, 1);
  ASSERT_EQ(map.submaps.size(), 1U);
  EXPECT_EQ(map.submaps[0].points_submap_m, (std::vector<Eigen::Vector3f>{{1, 2, 3}}));
  EXPECT_EQ(slam_map_content(map), file_of(none));
}

TEST(SlamMapFile, RequiresFactorsBetweenTwoExistingPoses) {
  const auto refusal = [](const Bytes& factors) { return refusal_of(file_of(factors), "factors"); };
  const auto relative = [&](int from, int to) {
    return refusal(
        Bytes().put(Count{1}).put(from).put(to).pose().identity().put(1.0).put(Count{0}).put(Count{0}).put(Count{0}));
  };
  const auto prior = [&](int pose) {
    return refusal(Bytes().put(Count{0}).put(Count{1}).put(pose).pose().identity().put(Count{0}).put(Count{0}));
  };
  const auto gravity = [&](int pose, double sigma_rad) {
    return refusal(
        Bytes().put(Count{0}).put(Count{0}).put(Count{1}).put(pose).put_all({0, 0, 1, sigma_rad}).put(Count{0}));
  };
  const auto position = [&](int before, int after) {
    Bytes bytes;
    bytes.put(Count{0}).put(Count{0}).put(Count{0}).put(Count{1}).put(before).put(after);
    return refusal(bytes.put_all({0.5, 1, 2, 3, 1, 1, 1, 9}));
  };
  for (const std::string& message : {relative(0, 1), relative(1, 0), prior(1), gravity(0, 0.5), position(0, 1)})
    EXPECT_EQ(message, "");
  EXPECT_EQ(position(1, 1), "") << "on a pose itself";
  for (const std::string& message :
       {relative(0, 0), relative(-1, 1), relative(0, 2), relative(2, 0), prior(2), prior(-1), gravity(2, 0.5),
        gravity(0, 0.0), gravity(0, std::nan("")), position(-1, 1), position(0, 2)}) {
    EXPECT_NE(message.find("counts do not fit"), std::string::npos) << message;
  }
}

// The check comes before the allocation.
TEST(SlamMapFile, RefusesCountsBeyondFileSize) {
  for (const Count count : {Count{1} << 60, Count{1000}}) {
    Bytes poses;
    poses.put(0.1).put(count);
    EXPECT_NE(refusal_of(poses.file(), "poses").find("counts do not fit"), std::string::npos);
    Bytes relatives;
    relatives.put(count);
    EXPECT_NE(refusal_of(file_of(relatives), "relatives").find("counts do not fit"), std::string::npos);
  }
  Bytes left_over;
  left_over.put(0.1);
  for (int kind = 0; kind < 8; ++kind) left_over.put(Count{0});
  EXPECT_EQ(refusal_of(left_over.file(), "empty").find("counts"), std::string::npos);
  left_over.put('x');
  EXPECT_NE(refusal_of(left_over.file(), "longer").find("counts do not fit"), std::string::npos);
  // A submap of points that reach beyond the end.
  Bytes points;
  points.put(0.1).put(Count{1}).pose().put(Count{0}).put(Count{0}).put(Count{0}).put(Count{0}).put(Count{0});
  points.put(Count{1}).put(std::int32_t{0}).put(Count{2}).put(1.0F).put(2.0F).put(3.0F).put(4.0F).put(5.0F);
  EXPECT_NE(refusal_of(points.file(), "points").find("counts do not fit"), std::string::npos);
  points.put(6.0F).put(Count{0});
  EXPECT_EQ(refusal_of(points.file(), "points"), "");
}

TEST(SlamMapFile, IsRecognizedByFileExtension) {
  EXPECT_TRUE(is_slam_map_file("a/b.slam"));
  EXPECT_FALSE(is_slam_map_file("a/slam"));
  EXPECT_FALSE(is_slam_map_file("b.ot"));
}

/// Keeps a map, or none.
class Keeper : public Agent, public SavedMapProvider {
 public:
  explicit Keeper(bool keeps) : map_(keeps ? std::make_shared<const SavedMap>(small_map()) : nullptr) {}
  const Action& step(const Observation&) override { return action_; }
  std::shared_ptr<const SavedMap> saved_map() const override { return map_; }

 private:
  std::shared_ptr<const SavedMap> map_;
  Action action_;
};

class OtherAgent : public Agent {
 public:
  const Action& step(const Observation&) override { return action_; }

 private:
  Action action_;
};

class SlamMapRecords : public ::testing::Test {
 protected:
  /// Four vehicles: a and c keep a map, b could, d is of another kind.
  std::vector<std::filesystem::path> record(const std::vector<std::string>& vehicles, bool any = true) {
    SlamMapConfig config;
    config.vehicles = vehicles;
    config.folder = "kept";
    const auto recorder = make_slam_map_recorder(config);
    RunInfo info;
    info.directory = folder_.path();
    info.vehicle_names = {"a", "b", "c", "d"};
    recorder->begin(info);
    std::vector<std::unique_ptr<Agent>> agents;
    for (const bool keeps : {any, false, any}) agents.push_back(std::make_unique<Keeper>(keeps));
    agents.push_back(std::make_unique<OtherAgent>());
    TickView tick;
    tick.agents = agents;
    recorder->write(tick);
    recorder->write(tick);
    return recorder->finish();
  }
  std::string refusal(const std::vector<std::string>& vehicles, bool any = true) {
    try {
      record(vehicles, any);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  TemporaryDirectory folder_;
};

TEST_F(SlamMapRecords, CoverAllOrOnlyNamedKeepers) {
  using Paths = std::vector<std::filesystem::path>;
  EXPECT_EQ(record({}), (Paths{"kept/a.slam", "kept/c.slam"}));
  EXPECT_EQ(read_slam_map(folder_.path() / "kept/c.slam").graph.num_poses(), 3);
  EXPECT_EQ(record({"c"}), (Paths{"kept/c.slam"}));
}

TEST_F(SlamMapRecords, RefuseVehiclesWithoutMapByName) {
  EXPECT_NE(refusal({"a", "b"}).find("on b, found another"), std::string::npos);
  EXPECT_NE(refusal({"d"}).find("on d, found another"), std::string::npos);
  EXPECT_NE(refusal({"x"}).find("found 'x'"), std::string::npos);
  EXPECT_NE(refusal({}, false).find("found none"), std::string::npos);
  EXPECT_EQ(refusal({"a", "c"}), "");
}

Scenario campus(const std::string& file, const ConfigChanges& changes) {
  ConfigChanges all = {{"recorders", "[]"}, {"snapshots", "[]"}};
  all.insert(all.end(), changes.begin(), changes.end());
  return load_scenario(std::string(SWIFTLET_SOURCE_DIR) + "/scenarios/" + file, all);
}

constexpr const char* kGlobal = "vehicles[0].agent.localization.global";

/// Map of half a lap around the building.
std::filesystem::path map_of_the_campus() {
  Scenario scenario =
      campus("campus_slam.yaml", {{"vehicles[0].agent.mapping", "none"}, {std::string(kGlobal) + ".enabled", "true"}});
  scenario.duration_s = 30.0;
  Simulation simulation(validated(scenario), 2);
  while (!simulation.finished()) simulation.tick();
  const auto* provider = dynamic_cast<const SavedMapProvider*>(simulation.view().agents[0].get());
  if (provider == nullptr) throw std::logic_error("expected a vehicle that keeps a map");
  write_file(temporary("campus"), slam_map_content(*provider->saved_map()));
  return temporary("campus");
}

TEST(SlamMap, LocatesFlightsInItsPlaceOnly) {
  const std::string map = map_of_the_campus().string();
  const auto fly_from = [&](const char* file, ConfigChanges changes, const auto& judge) {
    const ConfigChanges unknown = {{"vehicles[0].agent.mapping", "{type: none}"},
                                   {"vehicles[0].start.known", "nothing"},
                                   {"vehicles[0].agent.guidance", "{type: hover}"},
                                   {std::string(kGlobal) + ".enabled", "true"},
                                   {std::string(kGlobal) + ".map", map}};
    changes.insert(changes.end(), unknown.begin(), unknown.end());
    Scenario scenario = campus(file, changes);
    scenario.duration_s = 3.5;  // the start of SLAM takes 2 s
    Simulation simulation(validated(scenario), 2);
    while (!simulation.finished()) simulation.tick();
    judge(simulation.view().actions[0]->estimate, simulation.view().states[0]);
  };
  const std::pair<const char*, const char*> starts[] = {
      {"[9.0, -10.0, 3.5]", "130"}, {"[11.0, -8.0, 3.0]", "20"}, {"[6.0, -11.0, 3.0]", "200"}};
  int found = 0;
  for (const auto& [position_m, yaw_deg] : starts) {
    fly_from("campus_slam.yaml", {{"vehicles[0].start.position_m", position_m}, {"vehicles[0].start.yaw_deg", yaw_deg}},
             [&, at = position_m](const StateEstimate& e, const VehicleState& truth) {
               if (e.correction_revision == 0) return;
               ++found;
               EXPECT_LT((e.T_world_body().translation() - truth.p_world_m).norm(), 0.1) << at;
               const Matrix3 off = truth.T_world_body().linear().transpose() * e.T_world_body().linear();
               EXPECT_LT(std::abs(yaw_of(off)), 0.01) << at;
             });
  }
  EXPECT_GE(found, 2);
  fly_from("warehouse_explore.yaml", {}, [](const StateEstimate& e, const VehicleState&) {
    EXPECT_EQ(e.correction_revision, 0U) << "in a warehouse";
  });
}

TEST(SlamMap, RefusesUnreadableMapWithItsKey) {
  write_file(temporary("bad"), "no map");
  const Scenario scenario = campus("campus_slam.yaml", {{"vehicles[0].agent.mapping", "none"},
                                                        {std::string(kGlobal) + ".enabled", "true"},
                                                        {std::string(kGlobal) + ".map", temporary("bad").string()}});
  try {
    Simulation simulation(validated(scenario), 1);
    FAIL() << "a file without a map is accepted";
  } catch (const InputError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("localization.global.map: " + temporary("bad").string()), std::string::npos) << what;
  }
}

}  // namespace
}  // namespace swiftlet::sim
