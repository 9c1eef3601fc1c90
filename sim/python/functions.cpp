// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sim/python/bindings.hpp"
#include "sim/python/modules.hpp"
#include "swiftlet/core/guidance/rbl_obstacles.hpp"
#include "swiftlet/core/guidance/rbl_planner.hpp"
#include "swiftlet/core/uncertainty/error_distribution.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"
#include "swiftlet/core/uncertainty/voxel_probability.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"

namespace swiftlet::python {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

py::ssize_t rows_of(const Doubles& array, py::ssize_t width, const char* what) {
  if (array.size() == 0) return 0;
  if (array.ndim() < 2 || array.size() / array.shape(0) != width)
    throw py::value_error(std::string(what) + ": expected n rows of " + std::to_string(width) + " numbers");
  return array.shape(0);
}

Vector3 vector_at(const Doubles& array, py::ssize_t row) { return Vector3(array.data() + 3 * row); }
Matrix3 matrix_at(const Doubles& array, py::ssize_t row) { return Matrix3(array.data() + 9 * row).transpose(); }

Doubles point_covariances(const Doubles& directions, const Doubles& range_m, const py::object& R_world_lidar,
                          double sigma_range_m, const py::object& sigma_position_m,
                          const py::object& sigma_attitude_rad) {
  const py::ssize_t count = rows_of(directions, 3, "directions_lidar");
  if (range_m.size() != count) throw py::value_error("range_m: expected as many as there are directions");
  const Matrix3 R = matrix3_from(R_world_lidar, "R_world_lidar");
  const MeasurementNoise noise{sigma_range_m, vector_from(sigma_position_m, "sigma_position_m"),
                               vector_from(sigma_attitude_rad, "sigma_attitude_rad")};
  const Matrix7 Sigma_w = noise.Sigma_w();
  Doubles out({count, py::ssize_t{3}, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < count; ++i) {
    const Matrix3 C = point_covariance(vector_at(directions, i), range_m.data()[i], R, Sigma_w);  // symmetric
    std::copy_n(C.data(), 9, out.mutable_data() + 9 * i);
  }
  return out;
}

Doubles error_quantiles_m(const Doubles& covariances, double p) {
  const py::ssize_t count = rows_of(covariances, 9, "covariances_m2");
  Doubles out(count);
  for (py::ssize_t i = 0; i < count; ++i)
    out.mutable_data()[i] = ErrorDistribution(matrix_at(covariances, i)).quantile_m(p);
  return out;
}

Doubles error_means_m(const Doubles& covariances) {
  const py::ssize_t count = rows_of(covariances, 9, "covariances_m2");
  Doubles out(count);
  for (py::ssize_t i = 0; i < count; ++i) out.mutable_data()[i] = ErrorDistribution(matrix_at(covariances, i)).mean_m();
  return out;
}

Doubles correct_voxel_probabilities(const Doubles& points, const Doubles& covariances, double edge_m) {
  const py::ssize_t count = rows_of(points, 3, "points_world_m");
  if (rows_of(covariances, 9, "covariances_m2") != count)
    throw py::value_error("covariances_m2: expected as many as there are points");
  Doubles out(count);
  for (py::ssize_t i = 0; i < count; ++i)
    out.mutable_data()[i] = correct_voxel_probability(vector_at(points, i), matrix_at(covariances, i), edge_m);
  return out;
}

double probability_of_box(const py::object& mean, const py::object& Sigma, const py::object& low,
                          const py::object& high) {
  return box_probability(vector_from(mean, "mean_m"), matrix3_from(Sigma, "covariance_m2"),
                         {vector_from(low, "min_m"), vector_from(high, "max_m")});
}

/// Cells, centroids and rules of rule-based Lloyd for one agent.
class Rbl {
 public:
  Rbl(const std::string& cell, const std::string& rules, bool planar)
      : config_(read<RblCellConfig>(cell, "cell")), planner_(config_, read<RblRules>(rules, "rules"), planar) {}

  py::dict step(const py::object& position, const Doubles& neighbors, const py::object& goal, double dt_s,
                double z_min_m, double z_max_m, const Doubles& obstacles, double obstacle_edge_m) {
    const Vector3 p_local_m = vector_from(position, "position_m");
    const std::vector<Vector3> others = vectors(neighbors, "neighbors_m");
    planner_.partition(p_local_m, others, z_min_m, z_max_m);
    const std::vector<Vector3> voxels = vectors(obstacles, "obstacles_m");
    if (!voxels.empty())
      cutter_.cut_convex(planner_.cell(), p_local_m, voxels, obstacle_edge_m, config_.encumbrance_m, config_.eta,
                         planner_.cuts());
    const RblPlanner::Step step = planner_.update(vector_from(goal, "goal_m"), dt_s);
    py::dict out;
    out["centroid_m"] = py::array_t<double>(3, step.centroid_local_m.data());
    out["sensing_centroid_m"] = py::array_t<double>(3, step.sensing_local_m.data());
    out["destination_m"] = py::array_t<double>(3, step.destination_local_m.data());
    out["empty_cell"] = step.empty_cell;
    out["beta_m"] = planner_.state().beta_m;
    out["theta_rad"] = planner_.state().theta_rad;
    out["phi_rad"] = planner_.state().phi_rad;
    return out;
  }

 private:
  template <class Config>
  static Config read(const std::string& text, const char* name) {
    Config config;
    sim::read_config_text(text, name, [&](ConfigVisitor& v) { config.visit(v); });
    return config;
  }
  static std::vector<Vector3> vectors(const Doubles& array, const char* what) {
    const py::ssize_t count = rows_of(array, 3, what);
    std::vector<Vector3> out(count);
    for (py::ssize_t i = 0; i < count; ++i) out[i] = vector_at(array, i);
    return out;
  }

  RblCellConfig config_;
  RblPlanner planner_;
  ObstacleCutter cutter_;
};

}  // namespace

void bind_functions(py::module_& module) {
  module.def(
      "point_covariances", &point_covariances, py::arg("directions_lidar"), py::arg("range_m"),
      py::arg("R_world_lidar"), py::kw_only(), py::arg("sigma_range_m") = 0.03,
      py::arg("sigma_position_m") = py::make_tuple(0.05, 0.05, 0.05),
      py::arg("sigma_attitude_rad") = py::make_tuple(0.005, 0.005, 0.005),
      "(n, 3, 3) [m^2] covariance of the true point of each ray, world axes [Vrba 2025, eq. 44]. directions_lidar (n, "
      "3) unit vectors, range_m (n,) [m], R_world_lidar (3, 3).");
  module.def(
      "error_quantiles_m", &error_quantiles_m, py::arg("covariances_m2"), py::arg("p"),
      "(n,) [m] the error that is exceeded with probability 1 - p, of points with these covariances (n, 3, 3) [Vrba "
      "2025, sec. IV-B].");
  module.def("error_means_m", &error_means_m, py::arg("covariances_m2"), "(n,) [m] mean error of such points.");
  module.def("correct_voxel_probabilities", &correct_voxel_probabilities, py::arg("points_world_m"),
             py::arg("covariances_m2"), py::arg("edge_m"),
             "(n,) probability that the true point lies in the voxel in which it was measured [Vrba 2025, eq. 64].");
  module.def("box_probability", &probability_of_box, py::arg("mean_m"), py::arg("covariance_m2"), py::arg("min_m"),
             py::arg("max_m"), "Probability that a normal variable lies in an axis-aligned box [Vrba 2025, eq. 65].");
  py::class_<Rbl>(module, "_Rbl")
      .def(py::init<const std::string&, const std::string&, bool>())
      .def("step", &Rbl::step, py::arg("position_m"), py::arg("neighbors_m"), py::arg("goal_m"), py::arg("dt_s"),
           py::kw_only(), py::arg("z_min_m") = 0.0, py::arg("z_max_m") = 100.0, py::arg("obstacles_m") = Doubles(0),
           py::arg("obstacle_edge_m") = 0.2);
}

}  // namespace swiftlet::python
