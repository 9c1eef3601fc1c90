// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "swiftlet/core/stage_tables/mappers.hpp"

namespace swiftlet::testing {

/// A row of beams from the LiDAR's origin, and the ranges that they measured; 0 without return.
inline std::shared_ptr<const Scan> scan_along(const std::vector<Vector3>& directions_lidar,
                                              std::vector<float> ranges_m) {
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 1;
  beams->cols = static_cast<int>(directions_lidar.size());
  for (const Vector3& direction : directions_lidar) {
    beams->directions_lidar.push_back(direction.normalized().cast<float>());
  }
  beams->origins_lidar.assign(directions_lidar.size(), Eigen::Vector3f::Zero());
  beams->column_offset_s.assign(directions_lidar.size(), 0.0F);
  auto scan = std::make_shared<Scan>();
  scan->beams = beams;
  scan->range_m = std::move(ranges_m);
  return scan;
}

/// A mapper, and a vehicle at (10.05, 0.05, 2.05) that sends it scans ten times a second.
struct MapperDriver {
  explicit MapperDriver(const Module& module) : mapper(make_mapper(module, {})) {
    estimate.valid = true;
    estimate.T_local_body.translation() = Vector3(10.05, 0.05, 2.05);
  }

  void see(std::shared_ptr<const Scan> scan, const std::vector<Track>& tracks = {}) {
    CloudRegistrar registrar(0.3);
    registrar.push(estimate);
    cloud = std::make_shared<LocalCloud>();
    ASSERT_TRUE(registrar.make(std::move(scan), *cloud));
    const std::shared_ptr<const LocalCloud> clouds[] = {cloud};
    observation.t += kNsPerSecond / 10;
    mapper->step({observation, estimate, clouds, tracks, relatives, {}, &submaps}, outbox);
  }
  void see_nothing() {
    observation.t += kNsPerSecond / 10;
    mapper->step({observation, estimate, {}, {}, {}, {}, &submaps}, outbox);
  }
  CellState state(const Vector3& p_local_m) const { return mapper->map().state(p_local_m); }
  std::vector<Vector3> occupied_m() const {
    std::vector<Vector3> all_m;
    mapper->map().occupied_within(estimate.T_local_body.translation(), 20.0, kEver, all_m);
    return all_m;
  }
  std::vector<Counter> counters() const {
    std::vector<Counter> all;
    mapper->append_counters(all);
    return all;
  }

  std::unique_ptr<Mapper> mapper;
  StateEstimate estimate;
  Observation observation;
  Outbox outbox;
  std::vector<RelativeEstimate> relatives;
  SubmapPoses submaps;
  std::shared_ptr<LocalCloud> cloud;
};

}  // namespace swiftlet::testing
