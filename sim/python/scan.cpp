// SPDX-License-Identifier: BSD-3-Clause
#include "sim/python/scan.hpp"

#include <pybind11/stl.h>

#include <algorithm>

#include "sim/python/bindings.hpp"
#include "sim/python/fields.hpp"

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

using ScanClass = py::class_<HeldScan>;

void bind_beams(ScanClass& scan) {
  scan.def_property_readonly("range_m", beams_of(&Scan::range_m), "(rows, cols) float32, [m] range; 0: no return.")
      .def_property_readonly("intensity", beams_of(&Scan::intensity), "(rows, cols) float32, received power.")
      .def_property_readonly("reflectivity", beams_of(&Scan::reflectivity),
                             "(rows, cols) float32, reflectivity; 1: white Lambertian.")
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
          "masked", [](const HeldScan& h) { return beams(h, h.scan->beams->masked, h.scan->beams); },
          "(rows, cols) uint8, 1: neither return nor free space, because the beam meets the own vehicle, or its range "
          "or "
          "direction is unknown.")
      .def_property_readonly(
          "T_body_lidar",
          [](const HeldScan& h) { return py::object(poses_of(&h.scan->T_body_lidar, 1, h.scan)[py::int_(0)]); },
          "(4, 4), mounting as calibrated.")
      .def("points_lidar_m", &points_lidar,
           "(n, 3) float32, [m] the returns in the frame of the LiDAR, in the order of `range_m[range_m > 0]`. A new "
           "array.");
}

void bind_truth(ScanClass& scan) {
  scan.def_property_readonly("true_range_m", truth_of(&sim::ScanTruth::range_m),
                             "(rows, cols) float32, [m] range without noise; 0: no surface in range.")
      .def_property_readonly("true_class", truth_of(&sim::ScanTruth::surface_class),
                             "(rows, cols) uint16, truth class of the surface: numbers of docs/conventions.md.")
      .def_property_readonly("true_instance", truth_of(&sim::ScanTruth::instance),
                             "(rows, cols) uint16, instance within the class; of vehicles, their number from 1.")
      .def_property_readonly("true_part", truth_of(&sim::ScanTruth::part), "(rows, cols) uint8, part of a vehicle.")
      .def_property_readonly("true_incidence_rad", truth_of(&sim::ScanTruth::incidence_rad),
                             "(rows, cols) float32, [rad] angle between beam and surface normal.")
      .def_property_readonly(
          "true_T_world_lidar",
          [](const HeldScan& h) -> py::object {
            if (!h.labeled) return py::none();
            const auto& poses = h.labeled->truth.T_world_lidar;
            return poses_of(poses.data(), poses.size(), h.labeled);
          },
          "(cols, 4, 4), or (1, 4, 4) of a frozen scan: true pose of the sensor when each column fired.");
}

}  // namespace

void bind_scan(py::module_& module) {
  ScanClass scan(module, "Scan",
                 "One sweep of one LiDAR. Arrays are read-only views that stay valid as long as they are referenced. "
                 "The true values of each beam are None without access to the truth.");
  scan.def_property_readonly(
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
          "range_max_m", [](const HeldScan& h) { return h.scan->range_max_m; }, "[m] largest range of the sensor.")
      .def("__repr__", [](const HeldScan& h) {
        return "<Scan of " + h.scan->sensor + " at " + std::to_string(to_seconds(h.scan->stamp)) + " s, " +
               std::to_string(h.scan->rows()) + " x " + std::to_string(h.scan->cols()) + ">";
      });
  bind_beams(scan);
  bind_truth(scan);
}

}  // namespace swiftlet::python
