// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "sim/python/bindings.hpp"
#include "sim/python/scan.hpp"
#include "sim/python/values.hpp"

namespace swiftlet::python {
namespace {

/// Bounds of plausible arguments. Wider bounds accept more values in wrong units.
struct ScanBounds {
  double sweep_max_s = 10.0;       ///< longest sweep; longer ones are usually in milliseconds
  double origin_max_m = 10.0;      ///< largest distance of a beam's origin; larger ones are usually in millimeters
  float far_factor = 10.0F;        ///< the median range exceeds range_max_m at most by this factor
  float unit_tolerance = 1e-3F;    ///< difference of a direction's length from 1; above the rounding of printed digits
  double time_tolerance_s = 1e-6;  ///< excess of a firing time over the duration; above the rounding of float32
};
constexpr ScanBounds kBounds;

std::string index_text(int beam, int cols) {
  return " at [" + std::to_string(beam / cols) + ", " + std::to_string(beam % cols) + "]";
}

/// An argument of the shape of the range image: (rows, cols), or (rows, cols, 3).
Numbers<float> image_from(const py::object& value, const char* what, std::vector<py::ssize_t> shape) {
  const py::array array = numbers_from(value, what);
  if (!std::equal(shape.begin(), shape.end(), array.shape(), array.shape() + array.ndim()))
    throw py::value_error(std::string(what) + ": expected (rows, cols" + (shape.size() == 3 ? ", 3" : "") +
                          ") as range_m has them, found an array of shape " + shown(array.attr("shape")));
  return Numbers<float>(array);
}

/// Throws ValueError when most returns are far beyond the largest range, as in millimeters.
void require_meters(std::vector<float> range_m, double range_max_m) {
  std::erase_if(range_m, [](float range) { return !std::isfinite(range) || range == 0.0F; });
  if (range_m.empty()) return;
  const auto median = range_m.begin() + static_cast<std::ptrdiff_t>(range_m.size() / 2);
  std::ranges::nth_element(range_m, median);
  if (*median > kBounds.far_factor * range_max_m)
    throw py::value_error("range_m: expected meters up to range_max_m, " + shown(py::cast(range_max_m)) +
                          ", found a median of " + shown(py::cast(*median)) + ": convert ranges in millimeters");
}

/// Copies ranges. Infinity and ranges beyond range_max_m become "no return", and the beam of NaN is masked.
void take_ranges(const Numbers<float>& range_m, Scan& scan, BeamTable& beams) {
  scan.range_m.assign(range_m.data(), range_m.data() + range_m.size());
  require_meters(scan.range_m, scan.range_max_m);
  beams.masked.assign(scan.range_m.size(), 0);
  for (int i = 0; i < beams.size(); ++i) {
    float& range = scan.range_m[i];
    if (range < 0.0F)
      throw py::value_error("range_m: expected no negative number, found " + std::to_string(range) +
                            index_text(i, beams.cols));
    beams.masked[i] = std::isnan(range);
    if (!(range <= static_cast<float>(scan.range_max_m))) range = 0.0F;
  }
}

/// A beam without return may lack a direction, which is then zero.
void take_directions(const Numbers<float>& directions, const Scan& scan, BeamTable& beams) {
  beams.directions_lidar.resize(scan.range_m.size());
  std::copy_n(directions.data(), directions.size(), beams.directions_lidar.front().data());
  for (int i = 0; i < beams.size(); ++i) {
    const float length = beams.directions_lidar[i].norm();
    if (std::abs(length - 1.0F) <= kBounds.unit_tolerance) continue;
    if (scan.range_m[i] > 0.0F)
      throw py::value_error("directions_lidar: expected unit vectors, found one of length " + std::to_string(length) +
                            index_text(i, beams.cols) + "; points are divided by their ranges");
    beams.directions_lidar[i].setZero();
  }
}

void take_origins(const Numbers<float>& origins_m, BeamTable& beams) {
  std::copy_n(origins_m.data(), origins_m.size(), beams.origins_lidar.front().data());
  for (int i = 0; i < beams.size(); ++i) {
    Eigen::Vector3f& origin_m = beams.origins_lidar[i];
    if (beams.masked[i] || beams.directions_lidar[i].isZero(0.0F)) origin_m.setZero();
    if (!(origin_m.norm() <= kBounds.origin_max_m))
      within(origin_m.norm(), 0.0, kBounds.origin_max_m, "origins_lidar_m: distance" + index_text(i, beams.cols));
  }
}

void take_reflectivity(const Numbers<float>& reflectivity, int cols, Scan& scan) {
  for (int i = 0; i < static_cast<int>(scan.range_m.size()); ++i) {
    if (scan.range_m[i] > 0.0F)
      scan.reflectivity[i] = finite(reflectivity.data()[i], "reflectivity" + index_text(i, cols));
  }
}

/// Firing times of columns, or of points. Sets the sweep duration of the scan.
std::vector<float> times_from(const py::object& offset_s, std::optional<double> duration_s, int rows, int cols,
                              Scan& scan) {
  if (offset_s.is_none()) {
    scan.duration = from_seconds(within(duration_s.value_or(0.0), 0.0, kBounds.sweep_max_s, "duration_s"));
    std::vector<float> even(cols);
    for (int i = 0; i < cols; ++i) even[i] = static_cast<float>(duration_s.value_or(0.0) * i / cols);
    return even;
  }
  const Numbers<double> numbers(numbers_from(offset_s, "offset_s"));
  const bool by_point = numbers.ndim() == 2 && numbers.shape(0) == rows && numbers.shape(1) == cols;
  if (!by_point && !(numbers.ndim() == 1 && numbers.size() == cols))
    throw py::value_error("offset_s: expected (cols,) or (rows, cols) as range_m has them, found an array of shape " +
                          shown(numbers.attr("shape")));
  std::vector<double> times(numbers.data(), numbers.data() + numbers.size());
  for (std::size_t i = 0; by_point && i < times.size(); ++i) {
    if (scan.range_m[i] == 0.0F && std::isnan(times[i])) times[i] = 0.0;
  }
  const double longest_s = within(duration_s.value_or(kBounds.sweep_max_s), 0.0, kBounds.sweep_max_s, "duration_s");
  for (const double time_s : times) within(time_s, 0.0, longest_s + kBounds.time_tolerance_s, "offset_s");
  scan.duration = from_seconds(duration_s.value_or(*std::ranges::max_element(times)));
  return {times.begin(), times.end()};
}

/// Sorts columns by time. Points with individual times become a column each.
void sort_by_time(const std::vector<float>& times_s, BeamTable& beams, Scan& scan) {
  if (static_cast<int>(times_s.size()) != beams.cols) {
    beams.cols *= beams.rows;
    beams.rows = 1;
  }
  std::vector<int> order(beams.cols);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](int column) { return times_s[column]; });
  const auto sort = [&](auto& values) {
    const auto before = values;
    for (int i = 0; i < beams.size(); ++i) values[i] = before[i - i % beams.cols + order[i % beams.cols]];
  };
  for (const int column : order) beams.column_offset_s.push_back(times_s[column]);
  sort(beams.directions_lidar);
  sort(beams.origins_lidar);
  sort(beams.masked);
  sort(scan.range_m);
  sort(scan.reflectivity);
}

HeldScan make_scan(const py::object& range_m, const py::object& directions_lidar, TimeNs t_ns,
                   std::optional<double> duration_s, const py::object& offset_s, const py::object& origins_lidar_m,
                   const std::string& sensor, double range_max_m, double sigma_range_m, const py::object& reflectivity,
                   const py::object& T_body_lidar) {
  const Numbers<float> ranges(numbers_from(range_m, "range_m"));
  if (ranges.ndim() != 2 || ranges.size() == 0 || ranges.size() > std::numeric_limits<int>::max())
    throw py::value_error("range_m: expected (rows, cols), at least 1 x 1, found an array of shape " +
                          shown(ranges.attr("shape")));
  const py::ssize_t rows = ranges.shape(0), cols = ranges.shape(1);
  auto beams = std::make_shared<BeamTable>();
  beams->rows = static_cast<int>(rows);
  beams->cols = static_cast<int>(cols);
  auto scan = std::make_shared<Scan>();
  scan->sensor = sensor;
  scan->stamp = t_ns;
  if (!(range_max_m > 0.0))
    throw py::value_error("range_max_m: expected more than 0, found " + shown(py::cast(range_max_m)));
  scan->range_max_m = finite(range_max_m, "range_max_m");
  scan->sigma_range_m = within(sigma_range_m, 0.0, range_max_m, "sigma_range_m");
  const bool has_mount = !T_body_lidar.is_none();
  if (has_mount) scan->T_body_lidar = rigid(pose_from(T_body_lidar, "T_body_lidar"), "T_body_lidar");
  take_ranges(ranges, *scan, *beams);
  take_directions(image_from(directions_lidar, "directions_lidar", {rows, cols, 3}), *scan, *beams);
  beams->origins_lidar.assign(scan->range_m.size(), Eigen::Vector3f::Zero());
  if (!origins_lidar_m.is_none()) take_origins(image_from(origins_lidar_m, "origins_lidar_m", {rows, cols, 3}), *beams);
  scan->intensity.assign(scan->range_m.size(), 0.0F);
  scan->reflectivity.assign(scan->range_m.size(), 0.0F);
  if (!reflectivity.is_none())
    take_reflectivity(image_from(reflectivity, "reflectivity", {rows, cols}), beams->cols, *scan);
  sort_by_time(times_from(offset_s, duration_s, beams->rows, beams->cols, *scan), *beams, *scan);
  scan->beams = std::move(beams);
  HeldScan held{std::shared_ptr<const Scan>(std::move(scan))};
  held.has_mount = has_mount;
  return held;
}

}  // namespace

void bind_make_scan(py::module_& module) {
  module.def(
      "make_scan", &make_scan, py::arg("range_m"), py::arg("directions_lidar"), py::arg("t_ns"), py::kw_only(),
      py::arg("duration_s") = py::none(), py::arg("offset_s") = py::none(), py::arg("origins_lidar_m") = py::none(),
      py::arg("sensor") = "lidar", py::arg("range_max_m") = 120.0, py::arg("sigma_range_m") = 0.02,
      py::arg("reflectivity") = py::none(), py::arg("T_body_lidar") = py::none(),
      "A scan from arrays. range_m (rows, cols) [m] along each beam; 0, inf, or beyond range_max_m: no return, so that "
      "the beam is free; NaN: unknown. directions_lidar (rows, cols, 3), unit vectors; a beam without return may lack "
      "its own, and is then unknown. origins_lidar_m (rows, cols, 3) [m]: where ranges are measured from, by default "
      "the origin of the LiDAR. t_ns: start of the sweep. offset_s [s]: firing times after t_ns of columns (cols,) or "
      "of points (rows, cols), which become columns in the order of their times. Without it columns fire one after "
      "another during duration_s [s]. sensor: name of the LiDAR in the scenario. T_body_lidar (4, 4): mounting; "
      "without it an Onboard takes that of its sensor. ValueError on other shapes, units and values.");
}

}  // namespace swiftlet::python
