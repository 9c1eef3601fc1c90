// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace swiftlet::sim {

/// Recorded time series of one vehicle. Empty: not recorded. NaN: unknown at that instant.
struct VehicleSeries {
  std::string name;
  std::vector<double> t_s, x_m, y_m, z_m, speed_mps;
  std::vector<double> clearance_m;
  std::vector<double> estimate_error_m;  ///< distance between estimated and true position
  std::vector<double> tracking_error_m;  ///< distance between reference and true position
};

/// Series of every vehicle with csv/NAME/state.csv or trajectories/NAME.tum, by name; at most `most` instants each.
std::vector<VehicleSeries> read_time_series(const std::filesystem::path& run_directory, std::size_t most = 1500);

/// A table of numbers with named columns. Non-numbers become NaN. Throws std::runtime_error.
struct NumberTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;

  const std::vector<double>* find(const std::string& name) const;
};
/// @param separator  ',' for CSV; ' ' for TUM files, whose header is a comment
NumberTable read_number_table(const std::filesystem::path& file, char separator, std::size_t most);

}  // namespace swiftlet::sim
