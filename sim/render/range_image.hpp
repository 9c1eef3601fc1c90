// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "sim/render/captions.hpp"
#include "swiftlet/core/scan.hpp"

namespace swiftlet::sim {

/// Which beam of a scan looks in a direction: unwraps any pattern onto the sphere of the sensor. For spinning sensors
/// the staggering of the rows is undone (each row by its own azimuths); patterns without rows fall back on the
/// nearest beam.
class BeamLookup {
 public:
  explicit BeamLookup(const BeamTable& beams);

  /// Beam that looks nearest to (azimuth, elevation) [rad], azimuth counter-clockwise from the sensor's x axis;
  /// -1 when none is near.
  int beam_at(double azimuth_rad, double elevation_rad) const;

  double elevation_min_rad() const { return elevation_min_rad_; }
  double elevation_max_rad() const { return elevation_max_rad_; }
  bool organized() const { return !rows_.empty(); }

 private:
  struct Row {
    int row = 0;
    double elevation_rad = 0.0;
    double azimuth_first_rad = 0.0;  // of column 0
  };
  void organize(const BeamTable& beams);
  void scatter(const BeamTable& beams);
  int in_rows(double azimuth_rad, double elevation_rad) const;
  int nearest(double azimuth_rad, double elevation_rad) const;

  int cols_ = 0;
  std::vector<Row> rows_;   // highest first; empty: no rows
  double pitch_rad_ = 0.0;  // from column to column, signed
  // Without rows: beams sorted into cells of azimuth and elevation.
  double cell_rad_ = 0.0;
  int cells_wide_ = 0;
  int cells_high_ = 0;
  std::vector<int> first_in_cell_;  // (cells + 1), into beams_in_cells_
  std::vector<int> beams_in_cells_;
  std::vector<Eigen::Vector2d> angles_rad_;  // by beam: azimuth, elevation
  double elevation_min_rad_ = 0.0;
  double elevation_max_rad_ = 0.0;
};

enum class ScanQuantity { kRange, kIntensity };

/// The scan over the whole canvas, with a color bar beside it: strips of azimuth, the sensor's x axis in the middle of
/// the first.
/// @param max_range_m  end of the color scale of ranges; 0: from the scan
/// @return  width left of the color bar [px]
int draw_range_image(Canvas& canvas, const Look& look, const Scan& scan, ScanQuantity quantity,
                     double max_range_m = 0.0);

}  // namespace swiftlet::sim
