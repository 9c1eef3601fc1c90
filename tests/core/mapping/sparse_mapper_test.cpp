// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/mapping/sparse_mapper.hpp"

#include <gtest/gtest.h>

#include "swiftlet/core/stages/mappers.hpp"

namespace swiftlet {
namespace {

/// Three beams ahead, to the left and up, from a vehicle that is turned to the left.
std::shared_ptr<Scan> scan(std::vector<float> ranges_m) {
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 1;
  beams->cols = 3;
  beams->directions_lidar = {Eigen::Vector3f::UnitX(), Eigen::Vector3f::UnitY(), Eigen::Vector3f::UnitZ()};
  beams->origins_lidar.assign(3, Eigen::Vector3f::Zero());
  beams->column_offset_s.assign(3, 0.0F);
  auto scan = std::make_shared<Scan>();
  scan->beams = beams;
  scan->range_m = std::move(ranges_m);
  return scan;
}

struct Mapping {
  explicit Mapping(const Module& module) : mapper(make_mapper(module, {})) {
    estimate.valid = true;
    estimate.T_local_body =
        make_pose({10.05, 0.05, 2.05}, Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitZ())));
    registrar.push(estimate);
  }
  void see(const std::shared_ptr<Scan>& scan) {
    const auto cloud = std::make_shared<LocalCloud>();
    ASSERT_TRUE(registrar.make(scan, *cloud));
    const std::shared_ptr<const LocalCloud> clouds[] = {cloud};
    observation.t += kNsPerSecond / 10;
    mapper->step({observation, estimate, clouds}, outbox);
  }

  std::unique_ptr<Mapper> mapper;
  CloudRegistrar registrar{0.3};
  StateEstimate estimate;
  Observation observation;
  Outbox outbox;
};

TEST(SparseMapper, TransformsHitsIntoTheLocalFrame) {
  Mapping mapping(Module(mapper_module_types(), "sparse"));
  mapping.see(scan({4.0F, 0.0F, 0.5F}));
  const OccupancyView& map = mapping.mapper->map();
  EXPECT_EQ(map.state({10.05, 4.05, 2.05}), CellState::kOccupied) << "ahead is +y";
  std::vector<Vector3> all;
  map.occupied_within({10, 0, 2}, 20.0, kEver, all);
  EXPECT_EQ(all.size(), 1U) << "a beam without return hits nothing, and what is nearer than range_min_m is left out";
}

TEST(SparseMapper, ClearsByBeamsWithoutReturn) {
  Mapping mapping(Module(mapper_module_types(), "sparse"));
  mapping.see(scan({4.0F, 0.0F, 0.0F}));
  for (int i = 0; i < 10; ++i) mapping.see(scan({0.0F, 0.0F, 0.0F}));
  EXPECT_EQ(mapping.mapper->map().state({10.05, 4.05, 2.05}), CellState::kFree);
}

TEST(Mappers, NoneMakesNothing) {
  EXPECT_EQ(make_mapper(Module(mapper_module_types(), "none"), {}), nullptr);
  Module unknown(mapper_module_types(), "none");
  unknown.type = "atlas";
  EXPECT_THROW(make_mapper(unknown, {}), std::invalid_argument);
}

TEST(SparseMapper, CountsReturnsBeyondItsReach) {
  Module module(mapper_module_types(), "sparse");
  module.as<SparseMapperConfig>().range_max_m = 10.0;
  Mapping mapping(module);
  mapping.see(scan({9.0F, 11.0F, 0.5F}));
  std::vector<Counter> counters;
  mapping.mapper->append_counters(counters);
  ASSERT_EQ(counters.size(), 1U);
  EXPECT_EQ(counters[0].count, 1U);
  EXPECT_EQ(counters[0].of, 2U) << "the own body is no return of the world";
  EXPECT_EQ(counters[0].setting, "range_max_m");
}

}  // namespace
}  // namespace swiftlet
