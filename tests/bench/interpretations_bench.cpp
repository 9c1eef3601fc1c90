// SPDX-License-Identifier: BSD-3-Clause
// The interpretations of what Vrba 2025 leaves open (VofodChoices), each alone against the defaults, on the same scans:
// an OS1-128 flies over a field with scattered trees, three UAVs fly past it between 4 and 45 m away and one takes off
// beside it. Counters: recall by distance among targets that at least two points hit, detections that are no target,
// mean distance of the right ones to the target's center, mean processor time of the three stages. docs/detection.md
// has the table.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/detection/vofod_stages.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/world/field.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "tests/bench/processor_time.hpp"
#include "tests/support/sensor_driver.hpp"

namespace swiftlet::sim {
namespace {

constexpr TimeNs kStep = 2'000'000;
constexpr int kTargets = 4;
constexpr int kScans = 300;      // 30 s
constexpr int kWarmUp = 20;      // the air must be explored first
constexpr double kGate_m = 3.0;  // sec. V-A

VehicleState state_of(int vehicle, TimeNs t) {
  const double s = to_seconds(t);
  const auto circle = [&](double radius_m, double speed_mps, double phase, double z_m) {
    const double a = phase + speed_mps / radius_m * s;
    VehicleState state = state_at({radius_m * std::cos(a), radius_m * std::sin(a), z_m}, a);
    state.v_world_mps = speed_mps * Vector3(-std::sin(a), std::cos(a), 0.0);
    return state;
  };
  VehicleState state;
  if (vehicle == 0) state = circle(10.0, 4.0, 0.0, 4.0 + std::sin(0.3 * s));
  if (vehicle == 1) state = circle(14.0, 6.0, 2.0, 5.0 + std::sin(0.5 * s));
  if (vehicle == 2) state = circle(6.0, -3.0, 1.0, 3.5 + 0.5 * std::sin(0.7 * s));
  if (vehicle == 3) state = circle(34.0, 8.0, 3.0, 7.0);
  if (vehicle == 4) state = state_at({2.0, 3.0, 0.2 + std::clamp(s - 8.0, 0.0, 4.0)});
  state.t = t;
  return state;
}

/// The scans of the flight with the noise of eq. (66) in their poses, or without.
const std::vector<std::shared_ptr<const LocalCloud>>& flight(bool noisy) {
  static std::array<std::vector<std::shared_ptr<const LocalCloud>>, 2> flights;
  auto& clouds = flights[noisy];
  if (!clouds.empty()) return clouds;
  FieldConfig field;
  field.clear_radius_m = 17.0;
  field.num_trees = 40;
  field.relief.amplitude_m = 0.0;
  const auto scene = std::make_shared<const Scene>(make_field(field, 1));
  SensorSetup setup = sensor_setup("os1", 1, kTargets + 1, std::make_shared<const StaticScene>(*scene));
  setup.scene = scene;
  const auto shape = quadrotor_shape();
  setup.vehicle_shapes.assign(kTargets + 1, shape);
  LidarConfig config;
  config.external_pose.enabled = noisy;
  config.noise.sigma_range_m = noisy ? 0.03 : 0.0;
  const auto lidar = make_lidar(config, std::move(setup));
  StateHistory history(kTargets + 1, 200);
  CloudRegistrar registrar(0.6);
  Observation observation;
  for (TimeNs now = 0; static_cast<int>(clouds.size()) < kScans; now += kStep) {
    for (int v = 0; v <= kTargets; ++v) history.push(v, state_of(v, now));
    StateEstimate estimate;
    estimate.t = now;
    estimate.valid = true;
    estimate.T_local_body = state_of(0, now).T_world_body();
    registrar.push(estimate);
    observation.clear();
    lidar->measure(now, history, observation);
    for (const auto& scan : observation.scans) {
      auto cloud = std::make_shared<LocalCloud>();
      registrar.make(scan, *cloud);
      clouds.push_back(cloud);
    }
  }
  return clouds;
}

struct Score {
  std::array<int, 3> seen{}, found{};  // by distance: < 10, < 20, farther
  int false_alarms = 0, right = 0;
  double error_sum_m = 0.0, cpu_s = 0.0;

  void add(const LocalCloud& cloud, const std::vector<Detection>& detections) {
    const Vector3 sensor_m = cloud.T_local_lidar.front().translation();
    const TimeNs middle = cloud.stamp() + cloud.scan->duration / 2;
    for (int v = 1; v <= kTargets; ++v) {
      const Vector3 at = state_of(v, middle).p_world_m;
      const auto near = [&](const Eigen::Vector3f& p) { return (p.cast<double>() - at).norm() < 1.0; };
      if (at.z() < 1.2 || std::count_if(cloud.points_local_m.begin(), cloud.points_local_m.end(), near) < 2) continue;
      const double distance_m = (at - sensor_m).norm();
      const int bin = distance_m < 10.0 ? 0 : distance_m < 20.0 ? 1 : 2;
      ++seen[bin];
      found[bin] += std::any_of(detections.begin(), detections.end(), [&](const Detection& d) {
        return (d.position_m - state_of(v, d.t).p_world_m).norm() < kGate_m;
      });
    }
    for (const Detection& d : detections) {
      double error_m = kGate_m;
      for (int v = 1; v <= kTargets; ++v) {
        error_m = std::min(error_m, (d.position_m - state_of(v, d.t).p_world_m).norm());
      }
      if (error_m >= kGate_m) {
        ++false_alarms;
      } else {
        ++right;
        error_sum_m += error_m;
      }
    }
  }
};

void interpretation(benchmark::State& state, bool noisy, const std::function<void(VofodConfig&)>& change) {
  VofodConfig config;
  config.map.extent = VoxelMapConfig::Extent::kBounded;
  config.map.size_m = {96.0, 96.0, 24.0};
  config.map.center_m = {0.0, 0.0, 8.0};
  change(config);
  const auto& clouds = flight(noisy);
  for (auto _ : state) {
    VofodStages stages(config);
    Score score;
    std::vector<Detection> detections;
    for (int i = 0; i < kScans; ++i) {
      detections.clear();
      const double start = processor_time_s();
      stages.cast_rays(*clouds[i]);
      stages.classify(*clouds[i], detections);
      stages.apply_rays(1);
      stages.find_separate();
      stages.remove_separate(1);
      score.cpu_s += processor_time_s() - start;
      if (i >= kWarmUp) score.add(*clouds[i], detections);
    }
    const char* const names[] = {"recall_0_10", "recall_10_20", "recall_20_45"};
    for (int b = 0; b < 3; ++b)
      state.counters[names[b]] = static_cast<double>(score.found[b]) / std::max(score.seen[b], 1);
    state.counters["false_per_min"] = score.false_alarms * 600.0 / (kScans - kWarmUp);
    state.counters["error_m"] = score.error_sum_m / std::max(score.right, 1);
    state.counters["stages_ms"] = 1e3 * score.cpu_s / kScans;
  }
}

void add_all(bool noisy) {
  const auto add = [noisy](const std::string& name, std::function<void(VofodConfig&)> change) {
    benchmark::RegisterBenchmark(((noisy ? "noisy/" : "ideal/") + name).c_str(),
                                 [=](benchmark::State& state) { interpretation(state, noisy, change); })
        ->Iterations(1)
        ->Unit(benchmark::kSecond);
  };
  add("default", [](VofodConfig&) {});
  add("clustering=voxels", [](VofodConfig& c) { c.choices.clustering = VofodChoices::Clustering::kVoxels; });
  add("position=box_center", [](VofodConfig& c) { c.choices.position = VofodChoices::Position::kBoxCenter; });
  add("close_to=confident", [](VofodConfig& c) { c.choices.close_to = VofodChoices::CloseTo::kConfident; });
  add("search=octahedron", [](VofodConfig& c) { c.choices.search = VofodChoices::Search::kOctahedron; });
  add("failed_search=clear", [](VofodConfig& c) { c.choices.failed_search = VofodChoices::FailedSearch::kClear; });
  add("sufficiency=background_ratio",
      [](VofodConfig& c) { c.choices.sufficiency = VofodChoices::Sufficiency::kBackgroundRatio; });
  add("map_update=before", [](VofodConfig& c) { c.choices.map_update = VofodChoices::MapUpdate::kBefore; });
  add("ray_end=voxel_before", [](VofodConfig& c) { c.choices.ray_end = VofodChoices::RayEnd::kVoxelBefore; });
  add("hit_voxels=keep", [](VofodConfig& c) { c.choices.hit_voxels = VofodChoices::HitVoxels::kKeep; });
  add("separate_becomes=free",
      [](VofodConfig& c) { c.choices.separate_becomes = VofodChoices::SeparateBecomes::kFree; });
  add("separate_reach=sphere", [](VofodConfig& c) { c.choices.separate_reach = VofodChoices::SeparateReach::kSphere; });
  add("min_points=1", [](VofodConfig& c) { c.min_points = 1; });
  // All of its interpretations but the removal of separate background, which it does in another way.
  add("interpretations of the released code", [](VofodConfig& c) {
    c.cluster_distance_m = c.close_distance_m;
    c.choices = {.clustering = VofodChoices::Clustering::kVoxels,
                 .position = VofodChoices::Position::kBoxCenter,
                 .search = VofodChoices::Search::kOctahedron,
                 .failed_search = VofodChoices::FailedSearch::kClear,
                 .sufficiency = VofodChoices::Sufficiency::kBackgroundRatio,
                 .map_update = VofodChoices::MapUpdate::kBefore,
                 .ray_end = VofodChoices::RayEnd::kVoxelBefore,
                 .hit_voxels = VofodChoices::HitVoxels::kKeep};
  });
}

const bool kRegistered = (add_all(false), add_all(true), true);

}  // namespace
}  // namespace swiftlet::sim
