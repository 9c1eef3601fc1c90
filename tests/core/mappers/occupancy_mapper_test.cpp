// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/mappers/occupancy_mapper.hpp"

#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include "tests/core/mappers/mapper_driver.hpp"
#include "tests/support/flown_scans.hpp"

namespace swiftlet {
namespace {

/// A row of beams ahead, five degrees apart or so.
std::shared_ptr<const Scan> row_of(const std::vector<float>& ranges_m) {
  std::vector<Vector3> directions;
  for (std::size_t i = 0; i < ranges_m.size(); ++i) directions.emplace_back(1.0, 0.1 * static_cast<double>(i), 0.0);
  return testing::scan_along(directions, ranges_m);
}

struct OccupancyMapping : testing::MapperDriver {
  explicit OccupancyMapping(const OccupancyMapperConfig& config) : MapperDriver(module_with(config)) {}
  static Module module_with(const OccupancyMapperConfig& config) {
    Module module(mapper_module_types(), "occupancy");
    module.as<OccupancyMapperConfig>() = config;
    return module;
  }
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
  setup.vehicle_names = {"listener", "sender"};
  const auto mapper_of = [&](VehicleId self, const char* rays_of, const char* rays_to) {
    setup.self = self;
    Module module(mapper_module_types(), "occupancy");
    module.as<OccupancyMapperConfig>().rays_of = rays_of;
    module.as<OccupancyMapperConfig>().send_rays_to = rays_to;
    return make_mapper(module, setup);
  };
  const auto sender = mapper_of(1, "", "listener"), listener = mapper_of(0, "sender", "");
  StateEstimate estimate;
  estimate.valid = true;
  estimate.T_local_body = make_pose({10.05, 0.05, 2.05}, Eigen::Quaterniond::Identity());
  CloudRegistrar registrar(0.3);
  registrar.push(estimate);
  auto cloud = std::make_shared<LocalCloud>();
  ASSERT_TRUE(registrar.make(row_of({4.0F, 0.0F, 0.0F, 0.0F, 6.0F, 0.0F, 0.0F, 0.0F}), *cloud));
  const std::shared_ptr<const LocalCloud> clouds[] = {cloud};
  Outbox sent(1), nothing(0);
  sender->step({{}, estimate, clouds, {}}, sent);
  ASSERT_EQ(sent.messages().size(), 1U);

  // The listener's world is its local frame, moved: it carries the rays over. It hovers where the second ray ended.
  StateEstimate own = estimate;
  own.T_world_local.translation() = Vector3(3, 0, 0);
  own.correction_revision = 1;
  own.T_local_body.translation() = Vector3(12.6, 2.3, 2.05);
  Observation observation;
  observation.messages = sent.messages();
  listener->step({observation, own, {}, {}}, nothing);
  EXPECT_EQ(sender->map().state({14.05, 0.05, 2.05}), CellState::kOccupied);
  EXPECT_EQ(listener->map().state({11.05, 0.05, 2.05}), CellState::kOccupied);
  EXPECT_EQ(listener->map().state({9.05, 0.05, 2.05}), CellState::kFree);
  EXPECT_EQ(listener->map().state({14.05, 0.05, 2.05}), CellState::kUnknown);
  const Vector3 second_m = Vector3(10.05, 0.05, 2.05) + 6.0 * Vector3(1.0, 0.4, 0.0).normalized();
  EXPECT_EQ(sender->map().state(second_m), CellState::kOccupied);
  EXPECT_NE(listener->map().state(second_m - Vector3(3, 0, 0)), CellState::kOccupied) << "the listener itself";
  EXPECT_TRUE(nothing.messages().empty());
}

TEST(OccupancyMapper, TakesOneColumnInSoMany) {
  OccupancyMapperConfig config;
  config.every_column = 4;
  OccupancyMapping mapping(config);
  mapping.see(row_of(std::vector<float>(8, 5.0F)));
  EXPECT_EQ(mapping.occupied_m().size(), 2U) << "columns 0 and 4";
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
      mapping.estimate.T_local_body = seen.T_world_body;
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

/// Beams ahead, to the left and up.
std::shared_ptr<const Scan> three_beams(std::vector<float> ranges_m) {
  return testing::scan_along({Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()}, std::move(ranges_m));
}

/// Takes every column and returns up to 10 m.
OccupancyMapperConfig near_config() {
  OccupancyMapperConfig config;
  config.every_column = 1;
  config.map.range_max_m = 10.0;
  return config;
}

TEST(OccupancyMapper, TransformsHitsIntoTheLocalFrame) {
  OccupancyMapping driver(near_config());
  driver.estimate.T_local_body.linear() = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitZ()).toRotationMatrix();
  driver.see(three_beams({4.0F, 0.0F, 0.5F}));
  EXPECT_EQ(driver.state({10.05, 4.05, 2.05}), CellState::kOccupied) << "ahead is +y";
  EXPECT_EQ(driver.occupied_m().size(), 1U)
      << "a beam without return hits nothing, and what is nearer than range_min_m is left out";
}

TEST(OccupancyMapper, CountsReturnsBeyondItsRange) {
  OccupancyMapping driver(near_config());
  driver.see(three_beams({9.0F, 11.0F, 0.5F}));
  ASSERT_EQ(driver.counters().size(), 1U);
  EXPECT_EQ(driver.counters()[0].count, 1U);
  EXPECT_EQ(driver.counters()[0].of, 2U) << "the own body is no return of the world";
  EXPECT_EQ(driver.counters()[0].setting, "range_max_m");
}

TEST(Mappers, NoneMakesNothing) {
  EXPECT_EQ(make_mapper(Module(mapper_module_types(), "none"), {}), nullptr);
  Module unknown(mapper_module_types(), "none");
  unknown.type = "atlas";
  EXPECT_THROW(make_mapper(unknown, {}), std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet
