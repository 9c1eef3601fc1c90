// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/sensors/lidar_faults_config.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"

namespace swiftlet::sim {

/// Applies LidarFaultsConfig to the sweeps of one LiDAR. Faults that are not configured cost nothing for each beam.
class LidarFaults {
 public:
  LidarFaults(const LidarFaultsConfig& config, bool ideal, std::uint64_t seed, const std::string& entity,
              int num_beams);

  /// Draws the faults of the beams from `first` on. Noise of a lost shot becomes -infinity, which no detection
  /// survives. Calls for separate ranges may run in parallel.
  void draw(std::uint32_t sweep, int first, std::span<float> range_normals);

  /// Factors of the reflectivity (beams), or empty: all 1.
  std::span<const float> reflectivity_factors() const { return reflectivity_factors_; }
  bool has_range_step() const { return config_.range_step_m > 0.0; }
  float rounded_m(float range_m) const {
    const auto step_m = static_cast<float>(config_.range_step_m);
    return step_m * std::rint(range_m / step_m);
  }

  /// Adds returns from the LiDAR's window and from the vehicle's own structure (rig) to a traced sweep.
  void add_near_returns(std::uint32_t sweep, VehicleId self, float range_min_m, LabeledScan& out) const;

 private:
  void add_window(std::uint32_t sweep, LabeledScan& out) const;
  void add_rig(VehicleId self, float range_min_m, LabeledScan& out) const;

  LidarFaultsConfig config_;
  Random share_random_, reflectivity_random_, window_random_;
  std::vector<float> uniforms_;                // (beams), scratch
  std::vector<float> reflectivity_factors_;    // (beams), of the current sweep
  std::vector<float> reflectivity_quantiles_;  // at equal steps of the probability
};

}  // namespace swiftlet::sim
