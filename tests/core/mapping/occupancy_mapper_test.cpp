// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/mapping/occupancy_mapper.hpp"

#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include "swiftlet/core/stages/mappers.hpp"
#include "tests/support/flown_scans.hpp"

namespace swiftlet {
namespace {

/// A row of eight beams ahead, five degrees apart or so, from a vehicle at (10, 0, 2).
std::shared_ptr<Scan> row_of(const std::vector<float>& ranges_m) {
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 1;
  beams->cols = static_cast<int>(ranges_m.size());
  for (int i = 0; i < beams->cols; ++i) {
    beams->directions_lidar.push_back(Eigen::Vector3f(1.0F, 0.1F * static_cast<float>(i), 0.0F).normalized());
  }
  beams->origins_lidar.assign(ranges_m.size(), Eigen::Vector3f::Zero());
  beams->column_offset_s.assign(ranges_m.size(), 0.0F);
  auto scan = std::make_shared<Scan>();
  scan->beams = beams;
  scan->range_m = ranges_m;
  return scan;
}

struct OccupancyMapping {
  explicit OccupancyMapping(const OccupancyMapperConfig& config) {
    Module module(mapper_module_types(), "occupancy");
    module.as<OccupancyMapperConfig>() = config;
    mapper = make_mapper(module, {});
    estimate.valid = true;
    put(make_pose({10.05, 0.05, 2.05}, Eigen::Quaterniond::Identity()));
  }
  void put(const Pose& T_local_body) {
    estimate.T_local_body = T_local_body;
    registrar = CloudRegistrar(0.3);
    registrar.push(estimate);
  }
  void see(std::shared_ptr<const Scan> scan, std::vector<Track> tracks = {}) {
    cloud = std::make_shared<LocalCloud>();
    ASSERT_TRUE(registrar.make(std::move(scan), *cloud));
    const std::shared_ptr<const LocalCloud> clouds[] = {cloud};
    observation.t += kNsPerSecond / 10;
    mapper->step({observation, estimate, clouds, tracks, relatives}, outbox);
  }
  CellState state(const Vector3& p_local_m) const { return mapper->map().state(p_local_m); }

  std::unique_ptr<Mapper> mapper;
  CloudRegistrar registrar{0.3};
  StateEstimate estimate;
  Observation observation;
  Outbox outbox;
  std::vector<RelativeEstimate> relatives;
  std::shared_ptr<LocalCloud> cloud;
};

TEST(OccupancyMapper, IgnoresRestingTeamMembers) {
  OccupancyMapping mapping{OccupancyMapperConfig{}};
  RelativeEstimate resting;
  resting.position_m = {14.05, 0.05, 2.05};
  mapping.relatives = {resting};
  mapping.see(row_of({4.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F}));
  EXPECT_NE(mapping.state({14.05, 0.05, 2.05}), CellState::kOccupied);
  mapping.relatives.clear();
  mapping.see(row_of({4.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F}));
  EXPECT_EQ(mapping.state({14.05, 0.05, 2.05}), CellState::kOccupied);
}

/// Two mappers of a team; one receives the reports of the other.
TEST(OccupancyMapper, MatchesTheMapOfRaySenders) {
  AgentSetup setup;
  setup.num_vehicles = 2;
  setup.vehicle_names = {"listener", "teller"};
  const auto mapper_of = [&](VehicleId self, const char* rays_of, const char* tell_to) {
    setup.self = self;
    Module module(mapper_module_types(), "occupancy");
    module.as<OccupancyMapperConfig>().rays_of = rays_of;
    module.as<OccupancyMapperConfig>().tell_rays_to = tell_to;
    return make_mapper(module, setup);
  };
  const auto teller = mapper_of(1, "", "listener"), listener = mapper_of(0, "teller", "");
  StateEstimate estimate;
  estimate.valid = true;
  estimate.T_local_body = make_pose({10.05, 0.05, 2.05}, Eigen::Quaterniond::Identity());
  CloudRegistrar registrar(0.3);
  registrar.push(estimate);
  auto cloud = std::make_shared<LocalCloud>();
  ASSERT_TRUE(registrar.make(row_of({4.0F, 0.0F, 0.0F, 0.0F, 6.0F, 0.0F, 0.0F, 0.0F}), *cloud));
  const std::shared_ptr<const LocalCloud> clouds[] = {cloud};
  Outbox says(1), nothing(0);
  teller->step({{}, estimate, clouds, {}}, says);
  ASSERT_EQ(says.messages().size(), 1U);

  // The listener's world is its local frame, moved: it carries the rays over. It hovers where the second ray ended.
  StateEstimate own = estimate;
  own.T_world_local.translation() = Vector3(3, 0, 0);
  own.correction_revision = 1;
  own.T_local_body.translation() = Vector3(12.6, 2.3, 2.05);
  Observation observation;
  observation.messages = says.messages();
  listener->step({observation, own, {}, {}}, nothing);
  EXPECT_EQ(teller->map().state({14.05, 0.05, 2.05}), CellState::kOccupied);
  EXPECT_EQ(listener->map().state({11.05, 0.05, 2.05}), CellState::kOccupied);
  EXPECT_EQ(listener->map().state({9.05, 0.05, 2.05}), CellState::kFree);
  EXPECT_EQ(listener->map().state({14.05, 0.05, 2.05}), CellState::kUnknown);
  const Vector3 second_m = Vector3(10.05, 0.05, 2.05) + 6.0 * Vector3(1.0, 0.4, 0.0).normalized();
  EXPECT_EQ(teller->map().state(second_m), CellState::kOccupied);
  EXPECT_NE(listener->map().state(second_m - Vector3(3, 0, 0)), CellState::kOccupied) << "the listener itself";
  EXPECT_TRUE(nothing.messages().empty());
}

TEST(OccupancyMapper, TakesOneColumnInSoMany) {
  OccupancyMapperConfig config;
  config.every_column = 4;
  OccupancyMapping mapping(config);
  mapping.see(row_of(std::vector<float>(8, 5.0F)));
  std::vector<Vector3> occupied;
  mapping.mapper->map().occupied_within({10, 0, 2}, 20.0, kEver, occupied);
  EXPECT_EQ(occupied.size(), 2U) << "columns 0 and 4";
  EXPECT_EQ(mapping.state({15.05, 0.05, 2.05}), CellState::kOccupied);
}

TEST(OccupancyMapper, ClearsToConfiguredRangeWithoutReturn) {
  OccupancyMapperConfig config;
  config.clear_range_m = 6.0;
  OccupancyMapping mapping(config);
  mapping.see(row_of({0.0F}));
  EXPECT_EQ(mapping.state({15.95, 0.05, 2.05}), CellState::kFree);
  EXPECT_EQ(mapping.state({16.25, 0.05, 2.05}), CellState::kUnknown);
  config.clear_range_m = 0.0;
  OccupancyMapping silent(config);
  silent.see(row_of({0.0F}));
  EXPECT_EQ(silent.state({11.05, 0.05, 2.05}), CellState::kUnknown);
}

// The track was last seen two meters farther back and moves on at 2 m/s.
TEST(OccupancyMapper, TrackedVehiclesAreNoObstacles) {
  OccupancyMapperConfig config;
  config.every_column = 1;
  config.tracked_radius_m = 0.5;
  Track track;
  track.t = -kNsPerSecond;
  track.position_m = {13.05, 0.05, 2.05};
  track.velocity_mps = {2.0, 0.0, 0.0};
  OccupancyMapping mapping(config);
  mapping.see(row_of({5.0F, 8.0F, 5.0F, 5.2F, 5.2F, 5.2F, 5.3F}), {track});
  EXPECT_NE(mapping.state({15.05, 0.05, 2.05}), CellState::kOccupied);
  const Vector3 beside = mapping.cloud->points_local_m[6].cast<double>();
  EXPECT_EQ(mapping.state(beside), CellState::kOccupied) << "an obstacle beside it stays";
  const double apart_m = (beside - Vector3(15.05, 0.05, 2.05)).norm();
  for (const double share : {0.9, 1.1}) {
    config.tracked_radius_m = share * apart_m;
    OccupancyMapping near(config);
    near.see(row_of({5.0F, 8.0F, 5.0F, 5.2F, 5.2F, 5.2F, 5.3F}), {track});
    EXPECT_EQ(near.state(beside) == CellState::kOccupied, share < 1.0) << apart_m;
  }
  OccupancyMapping without(config);
  without.see(row_of({5.0F}));
  EXPECT_EQ(without.state({15.05, 0.05, 2.05}), CellState::kOccupied);
}

// Noisy scans of an OS0-128, thinned by four: a map of some million cells.
TEST(OccupancyMapper, MatchesOctomapOnSimulatedScans) {
  for (const char* scenario : {"warehouse.yaml", "forest.yaml"}) {
    SCOPED_TRACE(scenario);
    OccupancyMapperConfig config;
    config.clear_range_m = 0.0;  // the library does not support beams without return
    OccupancyMapping mapping(config);
    octomap::OcTree tree(config.map.edge_m);
    for (const testing::FlownScan& seen : testing::fly_scans(scenario, 2, 5)) {
      mapping.put(seen.T_world_body);
      mapping.see(seen.scan);
      const LocalCloud& cloud = *mapping.cloud;
      const Eigen::Vector3f origin = cloud.T_local_lidar.front().translation().cast<float>();
      octomap::Pointcloud points;
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        const Eigen::Vector3f& p = cloud.points_local_m[i];
        const bool chosen = static_cast<int>(cloud.beam[i]) % seen.scan->cols() % 4 == 0;
        if (chosen && (p - origin).norm() >= config.range_min_m) points.push_back(p.x(), p.y(), p.z());
      }
      EXPECT_GT(points.size(), 5000U);
      tree.insertPointCloud(points, {origin.x(), origin.y(), origin.z()}, config.map.range_max_m);
    }
    const auto& map = dynamic_cast<const OccupancyMap&>(mapping.mapper->map());
    tree.expand();
    std::size_t count = 0, differ = 0;
    for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf, ++count) {
      const Cell cell = Cell(leaf.getKey()[0], leaf.getKey()[1], leaf.getKey()[2]) - Cell::Constant(32768);
      if (!map.known(cell) || map.log_odds(cell) != leaf->getLogOdds()) ++differ;
    }
    MapVoxels copy;
    map.append_voxels(copy);
    EXPECT_EQ(differ, 0U);
    EXPECT_EQ(copy.size(), count);
    EXPECT_GT(count, 500'000U);
  }
}

TEST(OccupancyMapper, CountsReturnsBeyondItsRange) {
  OccupancyMapperConfig config;
  config.every_column = 1;
  config.map.range_max_m = 10.0;
  OccupancyMapping mapping(config);
  mapping.see(row_of({9.0F, 11.0F, 12.0F, 0.5F, 0.0F, 0.0F, 0.0F, 0.0F}));
  std::vector<Counter> counters;
  mapping.mapper->append_counters(counters);
  ASSERT_EQ(counters.size(), 1U);
  EXPECT_EQ(counters[0].count, 2U);
  EXPECT_EQ(counters[0].of, 3U) << "the own body is no return of the world";
  EXPECT_EQ(counters[0].setting, "range_max_m");
}

}  // namespace
}  // namespace swiftlet
