// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sim/python/bindings.hpp"
#include "sim/python/values.hpp"
#include "swiftlet/core/guidance/rbl_agent.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/uncertainty/error_distribution.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"
#include "swiftlet/core/uncertainty/voxel_probability.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"

namespace swiftlet::python {
namespace {

using Doubles = Numbers<double>;

std::string at(const char* what, std::size_t row) { return std::string(what) + "[" + std::to_string(row) + "]"; }

std::vector<Vector3> vectors_from(const py::object& value, const char* what) {
  const Doubles array(numbers_from(value, what));
  if (array.size() > 0 && (array.ndim() != 2 || array.shape(1) != 3))
    throw py::value_error(std::string(what) + ": expected n rows of 3 numbers, found an array of shape " +
                          shown(array.attr("shape")));
  std::vector<Vector3> vectors;
  for (py::ssize_t i = 0; i < array.size(); i += 3)
    vectors.push_back(finite(Vector3(array.data() + i), at(what, vectors.size())));
  return vectors;
}

std::vector<Matrix3> covariances_from(const py::object& value, const char* what) {
  const Doubles array(numbers_from(value, what));
  if (array.size() > 0 && (array.ndim() != 3 || array.shape(1) != 3 || array.shape(2) != 3))
    throw py::value_error(std::string(what) + ": expected n matrices of 3 x 3 numbers, found an array of shape " +
                          shown(array.attr("shape")));
  std::vector<Matrix3> matrices;
  for (py::ssize_t i = 0; i < array.size(); i += 9)
    matrices.push_back(covariance(Matrix3(array.data() + i).transpose(), at(what, matrices.size())));
  return matrices;
}

Vector3 point_from(const py::object& value, const char* what) { return finite(vector_from(value, what), what); }

double positive(double value, const char* what) {
  if (value > 0.0) return finite(value, what);
  throw py::value_error(std::string(what) + ": expected more than 0, found " + shown(py::cast(value)));
}

Doubles point_covariances(const py::object& directions_lidar, const py::object& ranges_m,
                          const py::object& R_world_lidar, double sigma_range_m, const py::object& sigma_position_m,
                          const py::object& sigma_attitude_rad) {
  const std::vector<Vector3> directions = vectors_from(directions_lidar, "directions_lidar");
  const auto count = static_cast<py::ssize_t>(directions.size());
  const Doubles range_m(numbers_from(ranges_m, "range_m"));
  if (range_m.size() != count)
    throw py::value_error("range_m: expected as many as there are directions, " + std::to_string(count) + ", found " +
                          std::to_string(range_m.size()));
  const Matrix3 R = finite(matrix3_from(R_world_lidar, "R_world_lidar"), "R_world_lidar");
  const MeasurementNoise noise{finite(sigma_range_m, "sigma_range_m"), point_from(sigma_position_m, "sigma_position_m"),
                               point_from(sigma_attitude_rad, "sigma_attitude_rad")};
  const Matrix7 Sigma_w = noise.Sigma_w();
  Doubles out({count, py::ssize_t{3}, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < count; ++i) {
    const Matrix3 C = point_covariance(directions[i], finite(range_m.data()[i], at("range_m", i)), R, Sigma_w);
    std::copy_n(C.data(), 9, out.mutable_data() + 9 * i);
  }
  return out;
}

std::vector<ErrorDistribution> distributions_from(const py::object& covariances_m2) {
  std::vector<ErrorDistribution> distributions;
  for (const Matrix3& C : covariances_from(covariances_m2, "covariances_m2")) {
    (void)positive(C.trace(), "covariances_m2: trace");
    distributions.emplace_back(C);
  }
  return distributions;
}

template <class Rows, class Value>
Doubles each_of(const Rows& rows, const Value& value) {
  Doubles out(static_cast<py::ssize_t>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) out.mutable_data()[i] = value(i);
  return out;
}

Doubles error_quantiles_m(const py::object& covariances_m2, double p) {
  if (!(p > 0.0 && p < 1.0))
    throw py::value_error("p: expected a probability between 0 and 1, found " + shown(py::cast(p)));
  const auto distributions = distributions_from(covariances_m2);
  return each_of(distributions, [&](std::size_t i) { return distributions[i].quantile_m(p); });
}

Doubles error_means_m(const py::object& covariances_m2) {
  const auto distributions = distributions_from(covariances_m2);
  return each_of(distributions, [&](std::size_t i) { return distributions[i].mean_m(); });
}

Doubles correct_voxel_probabilities(const py::object& points_world_m, const py::object& covariances_m2, double edge_m) {
  const std::vector<Vector3> points = vectors_from(points_world_m, "points_world_m");
  const std::vector<Matrix3> covariances = covariances_from(covariances_m2, "covariances_m2");
  if (covariances.size() != points.size())
    throw py::value_error("covariances_m2: expected as many as there are points, " + std::to_string(points.size()) +
                          ", found " + std::to_string(covariances.size()));
  (void)positive(edge_m, "edge_m");
  return each_of(points, [&](std::size_t i) { return correct_voxel_probability(points[i], covariances[i], edge_m); });
}

double probability_of_box(const py::object& mean, const py::object& Sigma, const py::object& low,
                          const py::object& high) {
  const Vector3 min_m = vector_from(low, "min_m"), max_m = vector_from(high, "max_m");
  if (!(min_m.array() <= max_m.array()).all())
    throw py::value_error("max_m: expected no less than min_m, found " + shown(low) + " and " + shown(high));
  return box_probability(point_from(mean, "mean_m"), covariance(matrix3_from(Sigma, "covariance_m2"), "covariance_m2"),
                         {min_m, max_m});
}

/// Cells, centroids and rules of rule-based Lloyd (RBL) for one agent.
class Rbl {
 public:
  Rbl(const std::string& cell, const std::string& rules, bool planar)
      : agent_(read<RblCellConfig>(cell, "cell"), read<RblRules>(rules, "rules"), planar) {}

  py::dict step(const py::object& position, const py::object& neighbors, const py::object& goal, double dt_s,
                double z_min_m, double z_max_m, const py::object& obstacles, double obstacle_edge_m) {
    const Vector3 p_local_m = point_from(position, "position_m"), goal_local_m = point_from(goal, "goal_m");
    const std::vector<Vector3> others = vectors_from(neighbors, "neighbors_m");
    const std::vector<Vector3> voxels = vectors_from(obstacles, "obstacles_m");
    (void)positive(dt_s, "dt_s");
    (void)positive(obstacle_edge_m, "obstacle_edge_m");
    if (!(z_min_m <= z_max_m))
      throw py::value_error("z_max_m: expected no less than z_min_m, found " + shown(py::cast(z_max_m)));
    const RblAgent::Step step = agent_.step({.p_local_m = p_local_m,
                                             .neighbors_local_m = others,
                                             .goal_local_m = goal_local_m,
                                             .z_min_m = z_min_m,
                                             .z_max_m = z_max_m,
                                             .voxels_local_m = voxels,
                                             .voxel_edge_m = obstacle_edge_m},
                                            dt_s);
    py::dict out;
    out["centroid_m"] = py::array_t<double>(3, step.centroid_local_m.data());
    out["sensing_centroid_m"] = py::array_t<double>(3, step.sensing_local_m.data());
    out["destination_m"] = py::array_t<double>(3, step.destination_local_m.data());
    out["empty_cell"] = step.empty_cell;
    out["beta_m"] = step.beta_m;
    out["theta_rad"] = step.theta_rad;
    out["phi_rad"] = step.phi_rad;
    return out;
  }

 private:
  template <class Config>
  static Config read(const std::string& text, const char* name) {
    Config config;
    sim::read_config_text(text, name, [&](ConfigVisitor& v) { config.visit(v); });
    return config;
  }

  RblAgent agent_;
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
  py::class_<Random>(module, "Random",
                     "Random numbers that are functions of a counter, as the simulator draws them: the same "
                     "seed, purpose, entity, tick and index always give the same number.")
      .def(py::init<std::uint64_t, const std::string&, const std::string&>(), py::arg("seed"), py::arg("purpose"),
           py::arg("entity") = "")
      .def("uniform", py::overload_cast<std::uint32_t, std::uint32_t>(&Random::uniform, py::const_), py::arg("tick"),
           py::arg("index"), "Uniform in [0, 1).")
      .def("normal", &Random::normal, py::arg("tick"), py::arg("index"), "Standard normal.");
  py::class_<Rbl>(module, "_Rbl")
      .def(py::init<const std::string&, const std::string&, bool>())
      .def("step", &Rbl::step, py::arg("position_m"), py::arg("neighbors_m"), py::arg("goal_m"), py::arg("dt_s"),
           py::kw_only(), py::arg("z_min_m") = 0.0, py::arg("z_max_m") = 100.0,
           py::arg("obstacles_m") = py::make_tuple(), py::arg("obstacle_edge_m") = 0.2);
}

}  // namespace swiftlet::python
