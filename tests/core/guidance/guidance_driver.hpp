// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/stages/guidances.hpp"

namespace swiftlet::testing {

/// A map with a given list of occupied cells.
class ToldMap : public OccupancyView {
 public:
  explicit ToldMap(std::vector<Vector3> occupied_m, double edge_m = 0.2)
      : occupied_m_(std::move(occupied_m)), edge_m_(edge_m) {}

  double edge_m() const override { return edge_m_; }
  CellState state(const Vector3& p_m) const override {
    return distance_m(p_m, edge_m_) <= 0.0 ? CellState::kOccupied : CellState::kUnknown;
  }
  void occupied_within(const Vector3& center_m, double radius_m, TimeNs, std::vector<Vector3>& found_m) const override {
    found_m.clear();
    for (const Vector3& cell_m : occupied_m_) {
      if (to_cell_m(center_m, cell_m) <= radius_m) found_m.push_back(cell_m);
    }
  }
  void occupied_in(const Vector3& min_m, const Vector3& max_m, std::vector<Vector3>& found_m) const override {
    found_m.clear();
    const Eigen::AlignedBox3d box(min_m, max_m);
    for (const Vector3& cell_m : occupied_m_) {
      if (box.exteriorDistance(cell_m) <= 0.5 * edge_m_) found_m.push_back(cell_m);
    }
  }
  double distance_m(const Vector3& p_m, double max_m) const override {
    for (const Vector3& cell_m : occupied_m_) max_m = std::min(max_m, to_cell_m(p_m, cell_m));
    return max_m;
  }
  std::optional<SegmentHit> first_hit(const Vector3&, const Vector3&) const override { return std::nullopt; }
  std::uint64_t revision() const override { return 0; }
  bool changed_since(std::uint64_t, std::vector<VoxelGrid>&) const override { return false; }

 private:
  double to_cell_m(const Vector3& p_m, const Vector3& cell_m) const {
    return ((p_m - cell_m).cwiseAbs() - Vector3::Constant(0.5 * edge_m_)).cwiseMax(0.0).norm();
  }

  std::vector<Vector3> occupied_m_;
  double edge_m_;
};

/// One guidance, stepped tick by tick for a vehicle whose state the test sets.
class GuidanceDriver {
 public:
  template <class Config>
  GuidanceDriver(const char* type, const Config& config, const Vector3& start_m, double yaw_rad = 0.0) {
    setup.T_local_body_start = pose(start_m, yaw_rad);
    setup.num_vehicles = 8;
    for (int i = 1; i <= setup.num_vehicles; ++i) setup.vehicle_names.push_back("uav" + std::to_string(i));
    make(type, config);
    estimate.valid = true;
    put(start_m, yaw_rad);
  }

  /// Makes the guidance anew with the present `setup`.
  template <class Config>
  void make(const char* type, const Config& config) {
    Module module(guidance_module_types(), type);
    module.as<Config>() = config;
    guidance = make_guidance(module, {setup, MotionLimits{}});
  }

  static Pose pose(const Vector3& p_m, double yaw_rad) {
    return make_pose(p_m, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ())));
  }
  void put(const Vector3& p_m, double yaw_rad = 0.0) { estimate.T_local_body = pose(p_m, yaw_rad); }
  Vector3 p_m() const { return estimate.T_local_body.translation(); }

  /// Adds an ideal sensor's measurement of another vehicle in this tick, or one with the given covariance.
  void sees(VehicleId id, const Vector3& other_m, const Matrix3& covariance_body = 1e-8 * Matrix3::Identity()) {
    NeighborSample sample;
    sample.t = observation.t + from_seconds(dt_s);
    sample.id = id;
    sample.p_body_m = estimate.T_local_body.inverse() * other_m;
    sample.covariance_body = covariance_body;
    observation.neighbors.push_back(sample);
  }

  const GuidanceOutput& step() {
    observation.t += from_seconds(dt_s);
    estimate.t = observation.t;
    poses.push(estimate);
    guidance->step({.dt_s = dt_s,
                    .estimate = estimate,
                    .observation = observation,
                    .poses = poses,
                    .relatives = relatives,
                    .map = map},
                   out, outbox);
    observation.neighbors.clear();
    observation.messages.clear();
    return out;
  }

  /// Counter of a setting; the first counter when none is named.
  Counter counter(const std::string& setting = {}) const {
    std::vector<Counter> counters;
    guidance->append_counters(counters);
    for (const Counter& counter : counters) {
      if (setting.empty() || counter.setting == setting) return counter;
    }
    ADD_FAILURE() << "nothing is counted for \"" << setting << '"';
    return {};
  }

  double dt_s = 0.1;
  AgentSetup setup;
  std::unique_ptr<Guidance> guidance;
  StateEstimate estimate;
  Observation observation;
  LocalPoses poses;
  std::vector<RelativeEstimate> relatives;
  const OccupancyView* map = nullptr;
  GuidanceOutput out;
  Outbox outbox;
};

}  // namespace swiftlet::testing
