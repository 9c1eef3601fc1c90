// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/neighbor_view.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {

/// A camera of a mutual-localization sensor, with a conical field of view (a fisheye lens).
struct NeighborCamera {
  double yaw_deg = 0.0;
  double pitch_deg = 0.0;
  double fov_deg = 180.0;

  void visit(ConfigVisitor& v);
};

/// Other vehicles as measured by UVDAR (blinking markers in fisheye cameras; [Kamler 2025]) and similar sensors.
/// Bearings are precise, range errors grow with distance. Vehicles beyond the range, out of view, or behind an obstacle
/// or another vehicle are not measured.
struct NeighborsConfig : SensorConfigOf<NeighborsConfig> {
  std::string model;
  double rate_hz = 10.0;
  bool ideal = false;
  double range_max_m = 15.0;
  double range_min_m = 0.3;
  double sigma_bearing_deg = 1.0;
  double sigma_range_m = 0.05;
  double sigma_range_relative = 0.05;
  std::vector<NeighborCamera> cameras;
  double elevation_min_deg = -60.0;
  double elevation_max_deg = 60.0;
  bool occlusion = true;
  double dropout_probability = 0.05;
  double id_swap_probability = 0.0;

  void visit(ConfigVisitor& v) override;
  NeighborView view() const;
  void describe(AgentSetup& setup) const override;
};

/// `ideal` gives the exact state of every other vehicle, regardless of range and occlusion (the truth bypass; rate,
/// clock and latency still apply).
std::unique_ptr<Sensor> make_neighbors_sensor(const ModuleConfig& config, SensorSetup setup);

}  // namespace swiftlet::sim
