// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "progress.hpp"
#include "swiftlet/core/uncertainty/error_distribution.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"
#include "swiftlet/core/uncertainty/voxel_probability.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/plot/plot.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"

namespace swiftlet::tools {
namespace {

struct UncertaintyOptions {
  std::string sensor;
  std::optional<double> sigma_range_m;
  double sigma_position_m = 0.05;
  double sigma_rotation_rad = 0.005;
  double azimuth_deg = 0.0;
  double elevation_deg = 0.0;
  std::optional<double> range_max_m;
  std::vector<double> voxels_m{0.1, 0.25, 0.5, 1.0};
  double confidence = 0.9;
  std::string out;
};

struct Request {  // options with defaults from the sensor preset
  sim::RangeNoiseConfig range_noise;
  sim::DetectionConfig detection;
  double range_max_m = 100.0;
  Vector3 direction = Vector3::UnitX();
};

constexpr float kBrightness = 0.3F;  // reflectivity of the surface, at normal incidence

struct Line {
  double range_m = 0.0, sigma_range_m = 0.0, expected_m = 0.0, median_m = 0.0, exceeded_by_5_percent_m = 0.0,
         voxel_m = 0.0;
  std::vector<double> probabilities;  ///< probability of the correct voxel, indexed by voxel size
};

sim::LidarConfig lidar_preset(const std::string& name) {
  Module sensor{sim::sensor_module_types(), "lidar"};
  const auto visit = [&](ConfigVisitor& v) {
    v.module("sensor", sensor, sim::sensor_module_types(), "[-] the sensor");
  };
  sim::read_config_text("sensor: {type: lidar, model: " + name + "}", "--sensor " + name, visit);
  return dynamic_cast<const sim::LidarConfig&>(*sensor.config);
}

Request request_of(const UncertaintyOptions& options) {
  Request request;
  if (!options.sensor.empty()) {
    const sim::LidarConfig lidar = lidar_preset(options.sensor);
    request.range_noise = lidar.noise;
    request.detection = lidar.detection;
    request.range_max_m = lidar.range_max_m;
  }
  if (options.sigma_range_m) {
    request.range_noise = {};
    request.range_noise.sigma_range_m = *options.sigma_range_m;
  }
  if (options.range_max_m) request.range_max_m = *options.range_max_m;
  const double azimuth = options.azimuth_deg * std::numbers::pi / 180.0,
               elevation = options.elevation_deg * std::numbers::pi / 180.0;
  request.direction = {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                       std::sin(elevation)};
  return request;
}

// Probability that the true point lies in the same voxel as a measured point at the voxel's center.
double centered_probability(const Matrix3& Sigma, double voxel_m) {
  return box_probability(Vector3::Zero(), Sigma, {Vector3::Constant(-0.5 * voxel_m), Vector3::Constant(0.5 * voxel_m)});
}

// Smallest voxel edge for which that probability reaches `confidence`.
double voxel_for(const Matrix3& Sigma, double confidence) {
  const double sigma = std::sqrt(Sigma.trace());
  double low = 0.0, high = std::max(20.0 * sigma, 1e-6);
  for (int i = 0; i < 24; ++i) {  // to 1e-6 sigma
    const double middle = 0.5 * (low + high);
    (centered_probability(Sigma, middle) < confidence ? low : high) = middle;
  }
  return high;
}

Line line_at(double range_m, const Request& request, const UncertaintyOptions& options) {
  Line line;
  line.range_m = range_m;
  const sim::LidarMeasurement measurement(request.range_noise, request.detection, request.range_max_m, false);
  line.sigma_range_m = measurement.sigma_m(static_cast<float>(range_m), 1.0F, kBrightness);
  const MeasurementNoise noise{line.sigma_range_m, Vector3::Constant(options.sigma_position_m),
                               Vector3::Constant(options.sigma_rotation_rad)};
  const Matrix3 Sigma = point_covariance(request.direction, range_m, Matrix3::Identity(), noise.Sigma_w());
  if (Sigma.trace() > 0.0) {
    const ErrorDistribution error(Sigma);
    line.expected_m = error.mean_m();
    line.median_m = error.quantile_m(0.5);
    line.exceeded_by_5_percent_m = error.quantile_m(0.95);
    line.voxel_m = voxel_for(Sigma, options.confidence);
  }
  for (const double voxel_m : options.voxels_m) line.probabilities.push_back(centered_probability(Sigma, voxel_m));
  return line;
}

// Every `step_m` in range: about a dozen lines for the table, a hundred for the plot.
std::vector<Line> lines(double step_m, const Request& request, const UncertaintyOptions& options) {
  std::vector<Line> result;
  for (int k = 0; k * step_m <= request.range_max_m * (1.0 + 1e-9); ++k)
    result.push_back(line_at(k * step_m, request, options));
  return result;
}

double round_step_m(double range_m) {
  const double power = std::pow(10.0, std::floor(std::log10(range_m / 12.0)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (range_m / (factor * power) <= 15.0) return factor * power;
  }
  return 10.0 * power;
}

void print_table(const std::vector<Line>& table, const Request& request, const UncertaintyOptions& options) {
  fmt::print("{}\n", bold("Uncertainty of a measured point"));
  fmt::print(
      "range noise {:g} m{}, position {:g} m an axis, attitude {:g} rad an axis\n\n", table.front().sigma_range_m,
      request.range_noise.law == sim::RangeNoiseConfig::Law::kConstant && request.range_noise.table_sigma_m.empty()
          ? ""
          : " (at range 0; by the sensor's law, reflectivity 0.3)",
      options.sigma_position_m, options.sigma_rotation_rad);
  std::string header = fmt::format("{:>8} {:>10} {:>10} {:>12} {:>14}", "range", "expected", "median", "5 % exceed",
                                   fmt::format("voxel {:g} %", 100.0 * options.confidence));
  for (const double voxel_m : options.voxels_m) header += fmt::format(" {:>11}", fmt::format("P({:g} m)", voxel_m));
  fmt::print("{}\n{:>8} {:>10} {:>10} {:>12} {:>14}\n", header, "[m]", "error [m]", "error [m]", "error [m]",
             "edge [m]");
  for (const Line& line : table) {
    std::string text = fmt::format("{:>8g} {:>10.3f} {:>10.3f} {:>12.3f} {:>14.3f}", line.range_m, line.expected_m,
                                   line.median_m, line.exceeded_by_5_percent_m, line.voxel_m);
    for (const double p : line.probabilities) text += fmt::format(" {:>11.3f}", p);
    fmt::print("{}\n", text);
  }
  fmt::print(
      "\nP(edge): the point lies in the voxel of that edge in whose middle it was measured; \"voxel {:g} %\": the "
      "smallest for which that is so\n"
      "(docs/papers.md: VoFOD, section IV)\n",
      100.0 * options.confidence);
}

std::string csv(const std::vector<Line>& table, const UncertaintyOptions& options) {
  std::string text = "range_m,sigma_range_m,expected_error_m,median_error_m,error_95_percent_m,voxel_for_confidence_m";
  for (const double voxel_m : options.voxels_m) text += fmt::format(",probability_voxel_{:g}_m", voxel_m);
  text += "\n";
  for (const Line& line : table) {
    text += fmt::format("{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}", line.range_m, line.sigma_range_m, line.expected_m,
                        line.median_m, line.exceeded_by_5_percent_m, line.voxel_m);
    for (const double p : line.probabilities) text += fmt::format(",{:.6g}", p);
    text += "\n";
  }
  return text;
}

void draw(const std::vector<Line>& table, const UncertaintyOptions& options, const std::filesystem::path& file) {
  const auto column = [&](const auto& value_of) {
    std::vector<double> values;
    for (const Line& line : table) values.push_back(value_of(line));
    return values;
  };
  const std::vector<double> ranges = column([](const Line& line) { return line.range_m; });
  sim::plot::Figure figure(fmt::format("Position noise {:g} m, attitude noise {:g} rad", options.sigma_position_m,
                                       options.sigma_rotation_rad),
                           2);
  sim::plot::Panel& errors = figure.add_panel("Error of a measured point");
  errors.x.label = "range [m]";
  errors.y.label = "error [m]";
  errors.line("expected", ranges, column([](const Line& line) { return line.expected_m; }));
  errors.line("5 % are larger", ranges, column([](const Line& line) { return line.exceeded_by_5_percent_m; }),
              {.dash = sim::plot::Dash::kDashed});
  errors.line(fmt::format("voxel edge that is right in {:g} %", 100.0 * options.confidence), ranges,
              column([](const Line& line) { return line.voxel_m; }), {.dash = sim::plot::Dash::kDotted});
  sim::plot::Panel& voxels = figure.add_panel("Probability of the right voxel");
  voxels.x.label = "range [m]";
  voxels.y.label = "probability [-]";
  voxels.y.min = 0.0;
  voxels.y.max = 1.05;
  for (std::size_t i = 0; i < options.voxels_m.size(); ++i) {
    voxels.line(fmt::format("edge {:g} m", options.voxels_m[i]), ranges,
                column([&](const Line& line) { return line.probabilities[i]; }));
  }
  figure.write(file);
}

void answer(const UncertaintyOptions& options) {
  for (const double voxel_m : options.voxels_m) {
    if (!(voxel_m > 0.0)) throw sim::InputError(fmt::format("--voxel: expected edges above 0 m, found {:g}", voxel_m));
  }
  const Request request = request_of(options);
  print_table(lines(round_step_m(request.range_max_m), request, options), request, options);
  if (options.out.empty()) return;
  const std::filesystem::path directory = options.out;
  sim::make_directory(directory);
  const std::vector<Line> fine = lines(request.range_max_m / 100.0, request, options);
  sim::write_file(directory / "uncertainty.csv", csv(fine, options));
  draw(fine, options, directory / "uncertainty.svg");
  fmt::print("\nwritten to {}: uncertainty.csv, uncertainty.svg\n", directory.string());
}

}  // namespace

void add_uncertainty(CLI::App& app) {
  auto options = std::make_shared<UncertaintyOptions>();
  Subcommand command(app, "uncertainty",
                     "What error and what voxel size to expect of a LiDAR whose pose is noisy, over the range");
  command.option("--sensor", options->sensor,
                 "LiDAR of assets/sensors with the range noise and reach (default: 0.03 m, 100 m)",
                 {.value_name = "NAME"});
  command.option("--sigma-range", options->sigma_range_m, "Standard deviation of the range [m] (default: the sensor's)",
                 {.value_name = "M", .min = 0.0});
  command.option("--sigma-position", options->sigma_position_m,
                 "Standard deviation of the sensor's position, per axis [m]", {.value_name = "M", .min = 0.0});
  command.option("--sigma-rotation", options->sigma_rotation_rad,
                 "Standard deviation of the sensor's attitude, per axis [rad]", {.value_name = "RAD", .min = 0.0});
  command.option("--azimuth", options->azimuth_deg, "Of the ray against the voxels' axes [deg]", {.value_name = "DEG"});
  command.option("--elevation", options->elevation_deg, "Of the ray against the voxels' axes [deg]",
                 {.value_name = "DEG"});
  command.option("--range-max", options->range_max_m, "Largest range [m]", {.value_name = "M", .min = 0.1, .max = 1e5});
  command.option("--voxel", options->voxels_m, "Voxel edges to evaluate [m]", {.value_name = "M"});
  command.option("--confidence", options->confidence, "Probability of the smallest voxel [-]",
                 {.value_name = "P", .min = 0.01, .max = 0.999});
  command.option("--out", options->out, "Folder for the CSV table and the plot", {.value_name = "DIR"});
  command.action([options] { answer(*options); });
}

}  // namespace swiftlet::tools
