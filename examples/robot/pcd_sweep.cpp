// SPDX-License-Identifier: BSD-3-Clause
#include "pcd_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "pcd_file.hpp"

namespace {

using swiftlet::TimeNs;

/// Plausible times of points after the start of the sweep. Wider bounds accept more times in wrong units.
constexpr double kLatestShare = 2.0;         // largest time, as a share of the sweep's duration
constexpr double kLeastShare = 0.01;         // smallest time of the last point, as a share of the sweep's duration
constexpr std::size_t kPointsToJudge = 100;  // number of points from which kLeastShare applies
constexpr double kEarliest_s = -0.001;       // smallest time; earlier points belong to another sweep

/// LiDAR model: matched points are weighted by sigma_range_m, and range_max_m bounds free space.
constexpr double kRangeMax_m = 120.0;
constexpr double kSigmaRange_m = 0.02;

const PcdPoints::Column& column_of(const PcdPoints& points, std::initializer_list<const char*> names) {
  std::string expected, found;
  for (const char* name : names) {
    const auto column = points.columns.find(name);
    if (column != points.columns.end()) return column->second;
    expected += (expected.empty() ? "" : " or ") + std::string(name);
  }
  for (const auto& [name, column] : points.columns) found += (found.empty() ? "" : ", ") + name;
  throw std::runtime_error("expected a field " + expected + ", found " + found);
}

/// Times of the points after the start of the sweep [s].
std::vector<double> times_of(const PcdPoints& points, TimeNs stamp, TimeNs duration) {
  const std::size_t count = points.columns.at("x").values.size();
  if (duration == 0 || count == 0) return std::vector<double>(count, 0.0);
  const auto& [is_whole_number, values] = column_of(points, {"t", "time", "timestamp", "offset_time"});
  const double unit_s = is_whole_number ? 1e-9 : 1.0;
  const double duration_s = swiftlet::to_seconds(duration);
  std::vector<double> times_s;
  for (const double value : values) times_s.push_back(std::isfinite(value) ? value * unit_s : 0.0);  // NaN: no return
  if (*std::ranges::max_element(times_s) > kLatestShare * duration_s) {  // times of the clock of `stamp`
    for (double& time_s : times_s) time_s = std::max(time_s - swiftlet::to_seconds(stamp), kEarliest_s);
  }
  const double first_s = *std::ranges::min_element(times_s), last_s = *std::ranges::max_element(times_s);
  const bool ends_early = count >= kPointsToJudge && last_s < kLeastShare * duration_s;
  if (first_s < kEarliest_s || last_s > kLatestShare * duration_s || ends_early)
    throw std::runtime_error("expected times of the points within the sweep of " + std::to_string(duration_s) +
                             " s, whole numbers in nanoseconds and others in seconds, found " +
                             std::to_string(first_s) + " to " + std::to_string(last_s) + " s after its start");
  for (double& time_s : times_s) time_s = std::max(time_s, 0.0);
  return times_s;
}

}  // namespace

swiftlet::Scan read_sweep(const std::filesystem::path& file, TimeNs stamp, TimeNs duration,
                          const swiftlet::Pose& T_body_lidar) try {
  const PcdPoints points = read_pcd(file);
  const std::vector<double>& x = column_of(points, {"x"}).values;
  const std::vector<double>& y = column_of(points, {"y"}).values;
  const std::vector<double>& z = column_of(points, {"z"}).values;
  const std::vector<double> times_s = times_of(points, stamp, duration);

  // One column with one beam for each point, sorted by time.
  std::vector<std::size_t> order(times_s.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return times_s[a] < times_s[b]; });
  auto beams = std::make_shared<swiftlet::BeamTable>();
  swiftlet::Scan scan;
  for (const std::size_t i : order) {
    const Eigen::Vector3f p_lidar_m = Eigen::Vector3d(x[i], y[i], z[i]).cast<float>();
    const float range_m = p_lidar_m.norm();
    if (!(range_m > 0.0F) || !std::isfinite(range_m)) continue;  // no return
    beams->directions_lidar.push_back(p_lidar_m / range_m);
    beams->origins_lidar.push_back(Eigen::Vector3f::Zero());
    beams->column_offset_s.push_back(static_cast<float>(times_s[i]));
    scan.range_m.push_back(range_m);
  }
  beams->rows = 1;
  beams->cols = static_cast<int>(scan.range_m.size());
  scan.sensor = "lidar";
  scan.stamp = stamp;
  scan.duration = duration;
  scan.T_body_lidar = T_body_lidar;
  scan.range_max_m = kRangeMax_m;
  scan.sigma_range_m = kSigmaRange_m;
  scan.intensity.assign(scan.range_m.size(), 0.0F);
  scan.reflectivity.assign(scan.range_m.size(), 0.0F);
  scan.beams = std::move(beams);
  return scan;
} catch (const std::runtime_error& error) {
  throw std::runtime_error(file.string() + ": " + error.what());
}
