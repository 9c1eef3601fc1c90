// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace swiftlet::sim {

/// What a run directory tells of one vehicle over time. A quantity that was not recorded is empty. One that was not
/// known at an instant is NaN there.
struct VehicleSeries {
  std::string name;
  std::vector<double> t_s, x_m, y_m, z_m, speed_mps;
  std::vector<double> clearance_m;
  std::vector<double> estimate_error_m;  ///< estimated less true position, as a distance
  std::vector<double> tracking_error_m;  ///< reference less true position, as a distance
};

/// Of every vehicle that csv/NAME/state.csv or trajectories/NAME.tum tell of, by name; at most `most` instants each.
std::vector<VehicleSeries> read_time_series(const std::filesystem::path& run_directory, std::size_t most = 1500);

/// A table of numbers with named columns. What is no number is NaN. Throws std::runtime_error.
struct NumberTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;

  const std::vector<double>* find(const std::string& name) const;
};
/// @param separator  ',' for CSV; ' ' for TUM files, whose head is a comment
NumberTable read_number_table(const std::filesystem::path& file, char separator, std::size_t most);

}  // namespace swiftlet::sim
