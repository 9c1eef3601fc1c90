// SPDX-License-Identifier: BSD-3-Clause
#include "sim/python/scan.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "sim/python/bindings.hpp"
#include "sim/python/fields.hpp"
#include "sim/python/values.hpp"

namespace swiftlet::python {
namespace {

// An array of a value per beam, as (rows, cols); None when empty.
template <class Scalar>
py::object beams(const HeldScan& held, const std::vector<Scalar>& values, const std::shared_ptr<const void>& owner) {
  if (values.empty()) return py::none();
  return view_of(values.data(), {held.scan->rows(), held.scan->cols()}, owner);
}

template <class Scalar>
auto beams_of(std::vector<Scalar> Scan::*values) {
  return [values](const HeldScan& held) { return beams(held, (*held.scan).*values, held.scan); };
}

template <class Scalar>
auto truth_of(std::vector<Scalar> sim::ScanTruth::*values) {
  return [values](const HeldScan& held) -> py::object {
    if (!held.labeled) return py::none();
    return beams(held, held.labeled->truth.*values, held.labeled);
  };
}

py::object vectors_of(const HeldScan& held, const std::vector<Eigen::Vector3f>& vectors) {
  if (vectors.empty()) return py::none();
  return view_of(vectors.front().data(), {held.scan->rows(), held.scan->cols(), 3}, held.scan->beams);
}

py::array poses_of(const Pose* poses, std::size_t count, const std::shared_ptr<const void>& owner) {
  return view_of("d", {static_cast<py::ssize_t>(count), 4, 4}, {sizeof(Pose), 8, 32}, poses, owner);
}

py::array points_lidar(const HeldScan& held) {
  const Scan& scan = *held.scan;
  py::ssize_t count = 0;
  for (int i = 0; i < scan.size(); ++i) count += scan.hit(i) ? 1 : 0;
  py::array_t<float> points({count, py::ssize_t{3}});
  float* at = points.mutable_data();
  for (int i = 0; i < scan.size(); ++i) {
    if (!scan.hit(i)) continue;
    const Eigen::Vector3f p_lidar_m = scan.point_lidar(i);
    at = std::copy_n(p_lidar_m.data(), 3, at);
  }
  return points;
}

constexpr double kMaxSweep_s = 10.0;  // longer values are usually in milliseconds

std::string index_text(int beam, int cols) {
  return " at [" + std::to_string(beam / cols) + ", " + std::to_string(beam % cols) + "]";
}

/// An argument of the shape of the range image: (rows, cols), or (rows, cols, 3).
Numbers<float> image_from(const py::object& value, const char* what, std::vector<py::ssize_t> shape) {
  const py::array array = numbers_from(value, what);
  if (!std::equal(shape.begin(), shape.end(), array.shape(), array.shape() + array.ndim()))
    throw py::value_error(std::string(what) + ": expected (rows, cols" + (shape.size() == 3 ? ", 3" : "") +
                          ") as range_m has them");
  return Numbers<float>(array);
}

/// Copies ranges; a range that is not finite or beyond range_max_m becomes "no return".
void take_ranges(const Numbers<float>& range_m, int cols, Scan& scan) {
  scan.range_m.assign(range_m.data(), range_m.data() + range_m.size());
  for (int i = 0; i < static_cast<int>(scan.range_m.size()); ++i) {
    float& range = scan.range_m[i];
    if (range < 0.0F)
      throw py::value_error("range_m: expected no negative number, found " + std::to_string(range) +
                            index_text(i, cols));
    if (!(range <= static_cast<float>(scan.range_max_m))) range = 0.0F;
  }
}

/// A beam without return may lack a direction; it is then masked.
void take_directions(const Numbers<float>& directions, const Scan& scan, BeamTable& beams) {
  constexpr float kTolerance = 1e-3F;
  beams.directions_lidar.resize(scan.range_m.size());
  std::copy_n(directions.data(), directions.size(), beams.directions_lidar.front().data());
  beams.masked.assign(scan.range_m.size(), 0);
  for (int i = 0; i < beams.size(); ++i) {
    const float length = beams.directions_lidar[i].norm();
    if (std::abs(length - 1.0F) <= kTolerance) continue;
    if (scan.range_m[i] > 0.0F)
      throw py::value_error("directions_lidar: expected unit vectors, found one of length " + std::to_string(length) +
                            index_text(i, beams.cols) + "; points are divided by their ranges");
    beams.directions_lidar[i] = Eigen::Vector3f::UnitX();
    beams.masked[i] = 1;
  }
}

/// Firing times of columns, or of points. Sets the sweep duration of the scan.
std::vector<float> times_from(const py::object& offset_s, std::optional<double> duration_s, int rows, int cols,
                              Scan& scan) {
  if (offset_s.is_none()) {
    scan.duration = from_seconds(within(duration_s.value_or(0.0), 0.0, kMaxSweep_s, "duration_s"));
    std::vector<float> even(cols);
    for (int i = 0; i < cols; ++i) even[i] = static_cast<float>(duration_s.value_or(0.0) * i / cols);
    return even;
  }
  const Numbers<double> numbers(numbers_from(offset_s, "offset_s"));
  const bool by_point = numbers.ndim() == 2 && numbers.shape(0) == rows && numbers.shape(1) == cols;
  if (!by_point && !(numbers.ndim() == 1 && numbers.size() == cols))
    throw py::value_error("offset_s: expected (cols,) or (rows, cols) as range_m has them");
  std::vector<double> times(numbers.data(), numbers.data() + numbers.size());
  for (std::size_t i = 0; by_point && i < times.size(); ++i) {
    if (scan.range_m[i] == 0.0F && std::isnan(times[i])) times[i] = 0.0;
  }
  constexpr double kTolerance_s = 1e-6;  // above the rounding of float32
  const double longest_s = within(duration_s.value_or(kMaxSweep_s), 0.0, kMaxSweep_s, "duration_s");
  for (const double time_s : times) within(time_s, 0.0, longest_s + kTolerance_s, "offset_s");
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
  const auto sorted = [&](const auto& values) {
    auto out = values;
    for (int i = 0; i < beams.size(); ++i) out[i] = values[i - i % beams.cols + order[i % beams.cols]];
    return out;
  };
  for (const int column : order) beams.column_offset_s.push_back(times_s[column]);
  beams.directions_lidar = sorted(beams.directions_lidar);
  beams.masked = sorted(beams.masked);
  scan.range_m = sorted(scan.range_m);
  scan.reflectivity = sorted(scan.reflectivity);
}

HeldScan make_scan(const py::object& range_m, const py::object& directions_lidar, TimeNs t_ns,
                   std::optional<double> duration_s, const py::object& offset_s, const std::string& sensor,
                   double range_max_m, double sigma_range_m, const py::object& reflectivity,
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
  if (!T_body_lidar.is_none()) scan->T_body_lidar = rigid(pose_from(T_body_lidar, "T_body_lidar"), "T_body_lidar");
  take_ranges(ranges, beams->cols, *scan);
  take_directions(image_from(directions_lidar, "directions_lidar", {rows, cols, 3}), *scan, *beams);
  scan->intensity.assign(scan->range_m.size(), 0.0F);
  scan->reflectivity.assign(scan->range_m.size(), 0.0F);
  if (!reflectivity.is_none()) {
    const Numbers<float> values = image_from(reflectivity, "reflectivity", {rows, cols});
    for (int i = 0; i < beams->size(); ++i) {
      if (scan->range_m[i] > 0.0F)
        scan->reflectivity[i] = finite(values.data()[i], "reflectivity" + index_text(i, beams->cols));
    }
  }
  beams->origins_lidar.assign(scan->range_m.size(), Eigen::Vector3f::Zero());
  sort_by_time(times_from(offset_s, duration_s, beams->rows, beams->cols, *scan), *beams, *scan);
  scan->beams = std::move(beams);
  return HeldScan(std::shared_ptr<const Scan>(std::move(scan)));
}

void bind_make_scan(py::module_& module) {
  module.def(
      "make_scan", &make_scan, py::arg("range_m"), py::arg("directions_lidar"), py::arg("t_ns"), py::kw_only(),
      py::arg("duration_s") = py::none(), py::arg("offset_s") = py::none(), py::arg("sensor") = "lidar",
      py::arg("range_max_m") = 120.0, py::arg("sigma_range_m") = 0.02, py::arg("reflectivity") = py::none(),
      py::arg("T_body_lidar") = py::none(),
      "A scan from arrays: range_m (rows, cols) [m], 0 or not finite: no return; directions_lidar (rows, "
      "cols, 3), unit vectors. offset_s [s]: firing times after t_ns of columns (cols,) or of points (rows, cols), "
      "which become columns in the order of their times. Without it columns fire one after another during duration_s "
      "[s]. T_body_lidar (4, 4): mounting.");
}

}  // namespace

void bind_scan(py::module_& module) {
  py::class_<HeldScan>(
      module, "Scan",
      "One sweep of one LiDAR. Arrays are read-only views that stay valid as long as they are referenced. "
      "The true values of each beam are None without access to the truth.")
      .def_property_readonly(
          "sensor", [](const HeldScan& h) { return h.scan->sensor; }, "Name of the sensor.")
      .def_property_readonly(
          "t_ns", [](const HeldScan& h) { return h.scan->stamp; }, "[ns] start of the sweep.")
      .def_property_readonly(
          "t_s", [](const HeldScan& h) { return to_seconds(h.scan->stamp); }, "[s] start of the sweep.")
      .def_property_readonly(
          "duration_s", [](const HeldScan& h) { return to_seconds(h.scan->duration); },
          "[s] length of the sweep; 0: all beams at once.")
      .def_property_readonly("rows", [](const HeldScan& h) { return h.scan->rows(); })
      .def_property_readonly("cols", [](const HeldScan& h) { return h.scan->cols(); })
      .def_property_readonly(
          "range_max_m", [](const HeldScan& h) { return h.scan->range_max_m; },
          "[m] beyond this the sensor returns nothing.")
      .def_property_readonly("range_m", beams_of(&Scan::range_m), "(rows, cols) float32, [m]; 0: no return.")
      .def_property_readonly("intensity", beams_of(&Scan::intensity), "(rows, cols) float32, received power.")
      .def_property_readonly("reflectivity", beams_of(&Scan::reflectivity),
                             "(rows, cols) float32; 1: white Lambertian.")
      .def_property_readonly(
          "directions_lidar", [](const HeldScan& h) { return vectors_of(h, h.scan->beams->directions_lidar); },
          "(rows, cols, 3) float32, unit vectors in the frame of the LiDAR.")
      .def_property_readonly(
          "origins_lidar_m", [](const HeldScan& h) { return vectors_of(h, h.scan->beams->origins_lidar); },
          "(rows, cols, 3) float32, [m] where the range of each beam is measured from, frame of the LiDAR.")
      .def_property_readonly(
          "column_offset_s",
          [](const HeldScan& h) {
            return view_of(h.scan->beams->column_offset_s.data(), {h.scan->cols()}, h.scan->beams);
          },
          "(cols,) float32, [s] firing time of each column after `t_s`.")
      .def_property_readonly(
          "T_body_lidar",
          [](const HeldScan& h) { return py::object(poses_of(&h.scan->T_body_lidar, 1, h.scan)[py::int_(0)]); },
          "(4, 4), mounting as calibrated.")
      .def("points_lidar_m", &points_lidar,
           "(n, 3) float32, [m] the returns in the frame of the LiDAR, in the order of `range_m[range_m > 0]`. A new "
           "array.")
      .def_property_readonly("true_range_m", truth_of(&sim::ScanTruth::range_m),
                             "(rows, cols) float32, [m] without noise; 0: nothing in reach.")
      .def_property_readonly("true_class", truth_of(&sim::ScanTruth::surface_class),
                             "(rows, cols) uint16, what was hit: numbers of docs/conventions.md.")
      .def_property_readonly("true_instance", truth_of(&sim::ScanTruth::instance),
                             "(rows, cols) uint16, which of its class; of vehicles, their number from 1.")
      .def_property_readonly("true_part", truth_of(&sim::ScanTruth::part), "(rows, cols) uint8, part of a vehicle.")
      .def_property_readonly("true_incidence_rad", truth_of(&sim::ScanTruth::incidence_rad),
                             "(rows, cols) float32, [rad] between beam and surface normal.")
      .def_property_readonly(
          "true_T_world_lidar",
          [](const HeldScan& h) -> py::object {
            if (!h.labeled) return py::none();
            const auto& poses = h.labeled->truth.T_world_lidar;
            return poses_of(poses.data(), poses.size(), h.labeled);
          },
          "(cols, 4, 4), or (1, 4, 4) of a frozen scan: true pose of the sensor when each column fired.")
      .def("__repr__", [](const HeldScan& h) {
        return "<Scan of " + h.scan->sensor + " at " + std::to_string(to_seconds(h.scan->stamp)) + " s, " +
               std::to_string(h.scan->rows()) + " x " + std::to_string(h.scan->cols()) + ">";
      });
  bind_make_scan(module);
}

}  // namespace swiftlet::python
