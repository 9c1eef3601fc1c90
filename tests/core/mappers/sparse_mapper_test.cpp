// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/mappers/sparse_mapper.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/mappers/occupancy_mapper.hpp"
#include "tests/core/mappers/mapper_driver.hpp"

namespace swiftlet {
namespace {

using testing::MapperDriver;

/// Beams ahead, to the left and up.
std::shared_ptr<const Scan> three_beams(std::vector<float> ranges_m) {
  return testing::scan_along({Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()}, std::move(ranges_m));
}

/// Both take every column and returns up to 10 m.
std::vector<Module> both_mappers() {
  Module sparse(mapper_module_types(), "sparse"), occupancy(mapper_module_types(), "occupancy");
  sparse.as<SparseMapperConfig>().range_max_m = 10.0;
  occupancy.as<OccupancyMapperConfig>().every_column = 1;
  occupancy.as<OccupancyMapperConfig>().map.range_max_m = 10.0;
  return {sparse, occupancy};
}

TEST(Mappers, TransformHitsIntoTheLocalFrame) {
  for (const Module& module : both_mappers()) {
    MapperDriver driver(module);
    driver.estimate.T_local_body.linear() = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitZ()).toRotationMatrix();
    driver.see(three_beams({4.0F, 0.0F, 0.5F}));
    EXPECT_EQ(driver.state({10.05, 4.05, 2.05}), CellState::kOccupied) << "ahead is +y";
    EXPECT_EQ(driver.occupied_m().size(), 1U)
        << "a beam without return hits nothing, and what is nearer than range_min_m is left out";
  }
}

TEST(Mappers, CountReturnsBeyondTheirRange) {
  for (const Module& module : both_mappers()) {
    MapperDriver driver(module);
    driver.see(three_beams({9.0F, 11.0F, 0.5F}));
    ASSERT_EQ(driver.counters().size(), 1U);
    EXPECT_EQ(driver.counters()[0].count, 1U);
    EXPECT_EQ(driver.counters()[0].of, 2U) << "the own body is no return of the world";
    EXPECT_EQ(driver.counters()[0].setting, "range_max_m");
  }
}

TEST(SparseMapper, ClearsByBeamsWithoutReturn) {
  MapperDriver driver(Module(mapper_module_types(), "sparse"));
  driver.see(three_beams({4.0F, 0.0F, 0.0F}));
  for (int i = 0; i < 10; ++i) driver.see(three_beams({0.0F, 0.0F, 0.0F}));
  EXPECT_EQ(driver.state({14.05, 0.05, 2.05}), CellState::kFree);
}

TEST(Mappers, NoneMakesNothing) {
  EXPECT_EQ(make_mapper(Module(mapper_module_types(), "none"), {}), nullptr);
  Module unknown(mapper_module_types(), "none");
  unknown.type = "atlas";
  EXPECT_THROW(make_mapper(unknown, {}), std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet
