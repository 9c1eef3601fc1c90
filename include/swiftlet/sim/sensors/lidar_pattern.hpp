// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/scan.hpp"

namespace swiftlet::sim {

/// Directions and times of the beams, in the sensor's frame. Azimuth counts from x towards y, elevation up from the x-y
/// plane.
class LidarPattern {
 public:
  virtual ~LidarPattern() = default;
  /// Fills the beams of sweep number `sweep`; sizes are constant, so that a second call allocates nothing.
  virtual void fill(std::uint32_t sweep, BeamTable& beams) const = 0;
  /// True if the beams are equal in every sweep.
  virtual bool repeats() const { return true; }
  /// Columns by which the direction of row `row` leads that of row 0 (staggering of an Ouster). After this shift, beams
  /// of similar azimuth lie in one column. Affects only the order of tracing.
  virtual int column_shift(int /*row*/) const { return 0; }
  /// True if rows and columns form an image. Otherwise beams are traced in the order of their directions.
  virtual bool is_image() const { return true; }
};

/// Spinning sensor with a table of beams that rotates clockwise seen from above, one column at a time (Ouster).
/// Beams start at a point that rotates at `beam_origin_m` around the axis. Column 0 lies at the connector, as in the
/// manufacturer's encoder; the connector points backward.
struct OusterConfig : ModuleConfigOf<OusterConfig> {
  int columns = 1024;
  int rows = 128;
  double elevation_top_deg = 21.3;  ///< OS1-128 by its metadata; the nominal "45 deg" are 43.1 deg
  double elevation_bottom_deg = -21.8;
  std::vector<double> elevations_deg;  ///< explicit table, top to bottom; empty: equal steps from top to bottom
  std::vector<double> azimuths_deg = {4.2, 1.4, -1.4, -4.2};
  double beam_origin_m = 0.015806;

  void visit(ConfigVisitor& v) override;
};

/// Livox Mid-360: 4 beams every 20 us on a curve that does not repeat between frames. Fitted to a public table of
/// shots (weighted RMS 0.87 deg): reproduces look and density, not the exact shots.
struct LivoxMid360Config : ModuleConfigOf<LivoxMid360Config> {
  void visit(ConfigVisitor& v) override;
};

/// Velodyne Puck and Puck LITE (VLP-16 manual 63-9243 rev D): 16 lasers in turn, 2.304 us apart, every 55.296 us.
struct VelodynePuckConfig : ModuleConfigOf<VelodynePuckConfig> {
  void visit(ConfigVisitor& v) override;
};

/// Equal steps in elevation and azimuth, as in the simulators of the papers.
struct UniformConfig : ModuleConfigOf<UniformConfig> {
  int columns = 1024;
  int rows = 128;
  double fov_vertical_deg = 45.0;
  double elevation_center_deg = 0.0;
  double fov_horizontal_deg = 360.0;

  void visit(ConfigVisitor& v) override;
};

/// Any pattern: lines of azimuth_deg, elevation_deg, time_s (after the start of the sweep, ascending).
struct CsvPatternConfig : ModuleConfigOf<CsvPatternConfig> {
  std::string file;

  void visit(ConfigVisitor& v) override;
};

/// Type of beam pattern that a LiDAR's configuration can choose; the list is in lidar_pattern.cpp.
struct LidarPatternType {
  ModuleType module;
  /// @param sweep_s  duration of a sweep
  std::unique_ptr<LidarPattern> (*make)(const ModuleConfig& config, double sweep_s);
};

std::span<const ModuleType> lidar_pattern_types();
/// Throws InputError when a file is missing or malformed.
std::unique_ptr<LidarPattern> make_lidar_pattern(const Module& config, double sweep_s);

}  // namespace swiftlet::sim
