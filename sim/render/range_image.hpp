// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "sim/render/captions.hpp"
#include "swiftlet/core/base/scan.hpp"

namespace swiftlet::sim {

/// Finds the beam of a scan for a direction: unwraps any pattern onto the sensor's sphere. For spinning sensors the
/// staggering of rows is undone (each row by its own azimuths); for patterns without rows, the nearest beam is used.
class BeamLookup {
 public:
  explicit BeamLookup(const BeamTable& beams);

  /// Beam nearest to (azimuth, elevation) [rad], azimuth counter-clockwise from the sensor's x axis;
  /// -1 when none is near.
  int beam_at(double azimuth_rad, double elevation_rad) const;

  double elevation_min_rad() const { return elevation_min_rad_; }
  double elevation_max_rad() const { return elevation_max_rad_; }
  bool organized() const { return !rows_.empty(); }

 private:
  struct Row {
    int row = 0;
    double elevation_rad = 0.0;
    double azimuth_first_rad = 0.0;  // azimuth of column 0
  };
  void organize(const BeamTable& beams);
  void scatter(const BeamTable& beams);
  int in_rows(double azimuth_rad, double elevation_rad) const;
  int nearest(double azimuth_rad, double elevation_rad) const;

  int cols_ = 0;
  std::vector<Row> rows_;   // highest first; empty: pattern without rows
  double pitch_rad_ = 0.0;  // angle between columns, signed
  // Without rows: beams sorted into cells of azimuth and elevation.
  double cell_rad_ = 0.0;
  int cells_wide_ = 0;
  int cells_high_ = 0;
  std::vector<int> first_in_cell_;  // (cells + 1), indices into beams_in_cells_
  std::vector<int> beams_in_cells_;
  std::vector<Eigen::Vector2d> angles_rad_;  // azimuth and elevation, indexed by beam
  double elevation_min_rad_ = 0.0;
  double elevation_max_rad_ = 0.0;
};

enum class ScanQuantity { kRange, kIntensity };

/// Draws a scan over the whole canvas, with a color bar: strips of azimuth, with the sensor's x axis in the middle of
/// the first.
/// @param max_range_m  end of the color scale of ranges; 0: fitted to the scan
/// @return  width left of the color bar [px]
int draw_range_image(Canvas& canvas, const Look& look, const Scan& scan, ScanQuantity quantity,
                     double max_range_m = 0.0);

}  // namespace swiftlet::sim
