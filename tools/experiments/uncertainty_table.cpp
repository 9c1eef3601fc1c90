// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "experiments.hpp"
#include "noise_grid.hpp"
#include "parallel.hpp"
#include "swiftlet/core/uncertainty/grid_probability.hpp"

namespace swiftlet::tools {
namespace {

constexpr std::uint32_t kTableSamples = 100000;  // N, as published
constexpr int kCells = 100;                      // regions along an axis, as published

// Orientation of the regions. The document states only that they cover the samples and that the attitude is random.
// Its rows hardly depend on the flatness of the distribution, which fits regions along the ray.
enum class Regions { kAlongRay, kAlongWorld };

struct TableCase {
  std::size_t i_rad = 0, i_m = 0, i_range = 0;
  std::size_t draw = 0;  // index of the random draw: samples and sensor attitude
};

struct Difference {  // difference of the probabilities, over the regions
  double maximum = 0.0, mean = 0.0, deviation = 0.0;
};

std::vector<TableCase> all_cases(int draws) {
  std::vector<TableCase> cases;
  for (std::size_t i_rad = 0; i_rad < 3; ++i_rad) {
    for (std::size_t i_m = 0; i_m < 3; ++i_m) {
      for (std::size_t i_range = 0; i_range < 3; ++i_range) {
        for (int draw = 0; draw < draws; ++draw) cases.push_back({i_rad, i_m, i_range, static_cast<std::size_t>(draw)});
      }
    }
  }
  return cases;
}

// Uniform on SO(3): a quaternion of four normals.
Matrix3 random_rotation(const Random& random) {
  const auto n = random.normal3(0, 0);
  return Eigen::Quaterniond(random.normal(0, 1), n[0], n[1], n[2]).normalized().toRotationMatrix();
}

// Histogram of samples in regions that cover them, against the normal distribution's probabilities of the same regions.
Difference compare(const TableCase& one, Regions regions) {
  const double range_m = kPrintedRanges_m[one.i_range];
  const MeasurementNoise noise = noise_of(kSigma_m[one.i_m], kSigma_rad[one.i_rad]);
  const std::string entity = fmt::format("{}/{}/{}/{}", one.i_rad, one.i_m, one.i_range, one.draw);
  // Regions along the ray turn with the sensor, so the attitude has no effect.
  Pose T_world_lidar = Pose::Identity();
  if (regions == Regions::kAlongWorld)
    T_world_lidar.linear() = random_rotation(Random(1, "uncertainty-table.attitude", entity));

  const Random random(1, "uncertainty-table.noise", entity);
  std::vector<Vector3> samples(kTableSamples);
  CellGrid grid;
  for (std::uint32_t i = 0; i < kTableSamples; ++i) {
    samples[i] = true_point(Vector3::UnitX(), range_m, T_world_lidar, draw_noise(random, noise, i));
    grid.box.extend(samples[i]);
  }
  grid.counts = {kCells, kCells, kCells};

  const Matrix3 Sigma = point_covariance(Vector3::UnitX(), range_m, T_world_lidar.linear(), noise.Sigma_w());
  const Vector3 p_measured_m = T_world_lidar * (range_m * Vector3::UnitX());
  std::vector<double> difference = grid_probabilities(p_measured_m, Sigma, grid);
  const Vector3 cell = grid.cell_size_m();
  for (const Vector3& sample : samples) {
    const Eigen::Array3i at =
        (sample - grid.box.min()).cwiseQuotient(cell).array().floor().cast<int>().min(kCells - 1).max(0);
    difference[static_cast<std::size_t>((at[0] * kCells + at[1]) * kCells + at[2])] -= 1.0 / kTableSamples;
  }

  Difference result;
  double sum = 0.0, squares = 0.0;
  for (const double d : difference) {
    result.maximum = std::max(result.maximum, std::abs(d));
    sum += std::abs(d);
    squares += d * d;
  }
  const double count = static_cast<double>(difference.size());
  result.mean = sum / count;
  result.deviation = std::sqrt(squares / count - result.mean * result.mean);
  return result;
}

// Over all regions of all cases: the mean of means, the deviation pooled, the median over draws of the maximum.
Difference total_of(const std::vector<Difference>& results, int draws) {
  Difference total;
  double squares = 0.0;
  std::vector<double> maxima(static_cast<std::size_t>(draws), 0.0);
  for (std::size_t i = 0; i < results.size(); ++i) {
    total.mean += results[i].mean / static_cast<double>(results.size());
    squares += (results[i].deviation * results[i].deviation) / static_cast<double>(results.size());
    double& maximum = maxima[i % static_cast<std::size_t>(draws)];
    maximum = std::max(maximum, results[i].maximum);
  }
  total.deviation = std::sqrt(squares);
  std::sort(maxima.begin(), maxima.end());
  total.maximum = maxima[(maxima.size() - 1) / 2];
  return total;
}

struct Table {
  std::vector<TableCase> cases;
  std::vector<Difference> results;
  Difference total;
  std::vector<double> means, maxima;  // one for each of the 27 combinations
};

Table measure(const Experiment& experiment, Regions regions, int draws) {
  Table table;
  table.cases = all_cases(draws);
  table.results.resize(table.cases.size());
  const std::string what =
      regions == Regions::kAlongRay ? "combinations, regions along the ray" : "combinations, regions along the world";
  parallel_for(experiment, table.cases.size(), what,
               [&](std::size_t i) { table.results[i] = compare(table.cases[i], regions); });
  table.total = total_of(table.results, draws);
  table.means.assign(27, 0.0);
  table.maxima.assign(27, 0.0);
  for (std::size_t i = 0; i < table.cases.size(); ++i) {
    table.means[i / static_cast<std::size_t>(draws)] += table.results[i].mean / draws;
    table.maxima[i / static_cast<std::size_t>(draws)] += table.results[i].maximum / draws;
  }
  return table;
}

/// The row of one combination: "mean, sigma_rad 0.05, ...".
std::string row_of(const char* quantity, const TableCase& one) {
  return fmt::format("{}, sigma_rad {:g}, sigma_m {:g} m, d {:g} m", quantity, kSigma_rad[one.i_rad], kSigma_m[one.i_m],
                     kPrintedRanges_m[one.i_range]);
}

void add_rows(const Experiment& experiment, CsvTable& csv, const Table& table, const std::string& regions) {
  for (std::size_t i = 0; i < table.cases.size(); ++i) {
    const TableCase& one = table.cases[i];
    const auto published = [&](const char* quantity) { return experiment.published(row_of(quantity, one)).value; };
    csv.row(regions, {kSigma_rad[one.i_rad], kSigma_m[one.i_m], kPrintedRanges_m[one.i_range],
                      static_cast<double>(one.draw), table.results[i].maximum, table.results[i].mean,
                      table.results[i].deviation, published("largest"), published("mean"), published("deviation")});
  }
}

// A row of panels for each quantity, a panel for each attitude noise.
void draw(Experiment& experiment, const Table& ray, const Table& world) {
  sim::plot::Figure figure("Gaussian approximation against Monte-Carlo (Table I)", 3);
  figure.set_panel_size(480, 260);
  const std::vector<TableCase> cases = all_cases(1);
  for (const bool largest : {false, true}) {
    for (std::size_t i_rad = 0; i_rad < kSigma_rad.size(); ++i_rad) {
      sim::plot::Panel& panel =
          figure.add_panel(fmt::format("{}, σ_rad = {:g} rad", largest ? "largest" : "mean", kSigma_rad[i_rad]));
      std::vector<double> published, along_ray, along_world;
      for (std::size_t i = 0; i < cases.size(); ++i) {
        const TableCase& one = cases[i];
        if (one.i_rad != i_rad) continue;
        panel.x.categories.push_back(fmt::format("{:g} m, {:g} m", kSigma_m[one.i_m], kPrintedRanges_m[one.i_range]));
        published.push_back(experiment.published(row_of(largest ? "largest" : "mean", one)).value);
        along_ray.push_back(largest ? ray.maxima[i] : ray.means[i]);
        along_world.push_back(largest ? world.maxima[i] : world.means[i]);
      }
      panel.bars("published", published)
          .bars("ours, along the ray", along_ray)
          .bars("ours, along the world", along_world);
      panel.x.label = "position noise, range";
      panel.y.label = "difference of probability [-]";
      panel.y.min = 0.0;
      panel.y.max = largest ? 8e-4 : 2.2e-6;
      panel.legend = i_rad == 0 ? sim::plot::Legend::kAuto : sim::plot::Legend::kNone;
    }
  }
  experiment.write("uncertainty-table.svg", figure);
}

}  // namespace

void uncertainty_table(Experiment& experiment) {
  const Table ray = measure(experiment, Regions::kAlongRay, experiment.repetitions(3, 1));
  const Table world = measure(experiment, Regions::kAlongWorld, experiment.repetitions(3, 1));
  CsvTable csv({"regions", "sigma_rad", "sigma_m", "range_m", "draw", "max_d_r", "mean_d_r", "std_d_r", "published_max",
                "published_mean", "published_std"});
  add_rows(experiment, csv, ray, "ray");
  add_rows(experiment, csv, world, "world");
  experiment.write("uncertainty-table.csv", csv);
  draw(experiment, ray, world);

  const double largest = experiment.published("largest difference").value;
  experiment.within("mean difference over all regions", ray.total.mean, 0.25, 3);
  experiment.at_most("largest difference", ray.total.maximum, 1.25 * largest, 3);
  experiment.within("standard deviation over all regions", ray.total.deviation, 0.25, 3);
  experiment.within("mean, regions along the world's axes", world.total.mean, 0.25, 3,
                    "a flat distribution fills less of a box that lies at an angle");
  experiment.at_most("largest, regions along the world's axes", world.total.maximum, 1.25 * largest, 3,
                     "median over sets of random attitudes");
  const std::vector<TableCase> combinations = all_cases(1);
  for (std::size_t i = 0; i < combinations.size(); ++i) {
    experiment.within(row_of("mean", combinations[i]), ray.means[i], 0.25, 3);
  }
}

}  // namespace swiftlet::tools
