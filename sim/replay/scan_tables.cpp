// SPDX-License-Identifier: BSD-3-Clause
#include "sim/replay/scan_tables.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {
namespace {

using Json = nlohmann::ordered_json;

/// Every n-th row and column. A sensor with few rows is thinned only along its columns.
struct Lattice {
  int rows = 1, cols = 1, first_row = 0, first_col = 0;

  Lattice(const Scan& scan, std::size_t hits, std::size_t most, std::uint64_t number) {
    // [-] Largest number of rows of a scan that is thinned along its columns only.
    constexpr int kFewRows = 12;
    const double factor = std::max(1.0, static_cast<double>(hits) / static_cast<double>(most));
    if (scan.rows() > kFewRows) rows = std::max(1, static_cast<int>(std::sqrt(factor)));
    cols = std::max(1, static_cast<int>(std::ceil(factor / rows)));
    first_row = static_cast<int>(number % static_cast<std::uint64_t>(rows));
    first_col = static_cast<int>(number % static_cast<std::uint64_t>(cols));
  }
  bool takes(int row, int col) const { return row % rows == first_row && col % cols == first_col; }
};

/// Poses of the sensor at a few columns, for interpolation.
ReplayTable poses_of(const LabeledScan& labeled) {
  // [-] Stored poses of a sweep; the page interpolates between them.
  constexpr int kKnots = 5;
  ReplayTable poses(Json::object({{"table", "poses"}}).dump(), {{"col", 1.0},
                                                                {"x_m", 1e-3},
                                                                {"y_m", 1e-3},
                                                                {"z_m", 1e-3},
                                                                {"qx", 1e-5},
                                                                {"qy", 1e-5},
                                                                {"qz", 1e-5},
                                                                {"qw", 1e-5}});
  const auto& all = labeled.truth.T_world_lidar;
  const int knots = all.size() > 1 ? kKnots : 1;
  Eigen::Quaterniond last = Eigen::Quaterniond::Identity();
  for (int k = 0; k < knots; ++k) {
    const std::size_t col = knots == 1 ? 0 : k * (all.size() - 1) / (kKnots - 1);
    const Vector3 p = all[col].translation();
    Eigen::Quaterniond q(all[col].linear());
    if (q.dot(last) < 0.0) q.coeffs() = -q.coeffs();  // same hemisphere, so that the page can interpolate
    last = q;
    poses.add({static_cast<double>(col), p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()});
  }
  return poses;
}

}  // namespace

std::size_t append_scan(const LabeledScan& labeled, VehicleId vehicle, std::size_t most_points, std::uint64_t number,
                        ReplayBlock& block) {
  const Scan& scan = labeled.scan;
  std::size_t hits = 0;
  for (int i = 0; i < scan.size(); ++i) hits += scan.hit(i) ? 1 : 0;
  const Lattice lattice(scan, hits, most_points, number);
  const Json about = {{"table", "scan"},
                      {"vehicle", vehicle},
                      {"sensor", scan.sensor},
                      {"t_s", to_seconds(scan.stamp)},
                      {"duration_s", to_seconds(scan.duration)},
                      {"returns", hits}};
  ReplayTable points(about.dump(-1, ' ', false, Json::error_handler_t::replace), {{"row", 1.0},
                                                                                  {"col", 1.0},
                                                                                  {"azimuth_rad", 2e-4},
                                                                                  {"elevation_rad", 2e-4},
                                                                                  {"range_m", 0.01},
                                                                                  {"intensity_dB", 1.0},
                                                                                  {"class", 1.0},
                                                                                  {"instance", 1.0}});
  for (int i = 0; i < scan.size(); ++i) {
    if (!scan.hit(i)) continue;
    const int row = i / scan.cols(), col = i % scan.cols();
    const std::uint16_t surface = labeled.truth.surface_class[i], instance = labeled.truth.instance[i];
    const bool other_vehicle = surface == static_cast<std::uint16_t>(SurfaceClass::kVehicle) && instance != vehicle + 1;
    if (!other_vehicle && !lattice.takes(row, col)) continue;
    const Vector3 d = scan.beams->directions_lidar[i].cast<double>();
    // Least intensity in decibels.
    constexpr double kDarkest = 1e-4;
    const double intensity_dB =
        10.0 / elementary::log(10.0) * elementary::log(std::max<double>(scan.intensity[i], kDarkest));
    points.add({static_cast<double>(row), static_cast<double>(col), elementary::atan2(d.y(), d.x()),
                elementary::atan2(d.z(), elementary::hypot(d.x(), d.y())), scan.range_from_axis_m(i), intensity_dB,
                static_cast<double>(surface), static_cast<double>(instance)});
  }
  block.add(points);
  block.add(poses_of(labeled));
  return points.rows();
}

}  // namespace swiftlet::sim
