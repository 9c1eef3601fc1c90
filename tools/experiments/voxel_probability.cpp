// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "experiments.hpp"
#include "noise_grid.hpp"
#include "parallel.hpp"
#include "swiftlet/core/uncertainty/voxel_probability.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kVoxel_m = 1.0;  // as published
constexpr double kFarthestVoxel_m = 80.0;

// Position of the measured point in its voxel, which the document does not state: the middle, or random.
enum class Place { kCenter, kRandom };

Eigen::AlignedBox3d voxel_around(const Vector3& p_m, const Vector3& place) {
  const Vector3 low = p_m - kVoxel_m * place;
  return {low, low + Vector3::Constant(kVoxel_m)};
}

double probability(double range_m, const MeasurementNoise& noise, Place place) {
  const Matrix3 Sigma = point_covariance(Vector3::UnitX(), range_m, Matrix3::Identity(), noise.Sigma_w());
  const Vector3 p_m = range_m * Vector3::UnitX();
  if (place == Place::kCenter) return box_probability(p_m, Sigma, voxel_around(p_m, Vector3::Constant(0.5)));
  // Along the x axis the covariance is diagonal, so the average over places is a product of averages.
  double product = 1.0;
  constexpr int kPlaces = 50;
  for (int axis = 0; axis < 3; ++axis) {
    double sum = 0.0;
    for (int k = 0; k < kPlaces; ++k) {
      const double sigma = std::sqrt(2.0 * Sigma(axis, axis)), at = (k + 0.5) / kPlaces * kVoxel_m;
      sum += 0.5 * (std::erf((kVoxel_m - at) / sigma) + std::erf(at / sigma)) / kPlaces;
    }
    product *= sum;
  }
  return product;
}

struct VoxelSampled {
  double normal = 0.0, true_model = 0.0;  // share of samples in the voxel
};

VoxelSampled sample_voxel(const NoiseCase& one, std::uint32_t count) {
  const MeasurementNoise noise = one.noise();
  const Random random(1, "voxel-probability", fmt::format("{}/{}/{}", one.i_rad, one.i_m, one.range_m));
  const Jacobian37 J = point_jacobian(Vector3::UnitX(), one.range_m, Matrix3::Identity());
  const Vector3 p_m = one.range_m * Vector3::UnitX();
  const Eigen::AlignedBox3d voxel = voxel_around(p_m, Vector3::Constant(0.5));
  std::uint32_t normal = 0, true_model = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Eigen::Matrix<double, 7, 1> w = draw_noise(random, noise, i);
    normal += voxel.contains(p_m + J * w) ? 1U : 0U;
    true_model += voxel.contains(true_point(Vector3::UnitX(), one.range_m, Pose::Identity(), w)) ? 1U : 0U;
  }
  return {static_cast<double>(normal) / count, static_cast<double>(true_model) / count};
}

void draw(Experiment& experiment, const SampledNoise<VoxelSampled>& sampled) {
  sim::plot::Figure figure("Probability of the right voxel of 1 m (Fig. 6)", 3);
  figure.set_panel_size(400, 360);
  CsvTable csv({"sigma_rad", "sigma_m", "range_m", "probability_center", "probability_any_place"});
  for (std::size_t i_rad = 0; i_rad < 3; ++i_rad) {
    sim::plot::Panel& panel = figure.add_panel(fmt::format("σ_rad = {:g} rad", kSigma_rad[i_rad]));
    panel.x.label = "range [m]";
    panel.y.label = "probability [-]";
    panel.y.min = 0.0;
    panel.y.max = 1.05;
    if (i_rad != 1) panel.legend = sim::plot::Legend::kNone;
    for (std::size_t i_m = 0; i_m < 3; ++i_m) {
      const MeasurementNoise noise = noise_of(kSigma_m[i_m], kSigma_rad[i_rad]);
      std::vector<double> ranges, center, random;
      for (double range_m = 0.0; range_m <= kFarthestVoxel_m; range_m += 1.0) {
        ranges.push_back(range_m);
        center.push_back(probability(range_m, noise, Place::kCenter));
        random.push_back(probability(range_m, noise, Place::kRandom));
        csv.row({kSigma_rad[i_rad], kSigma_m[i_m], range_m, center.back(), random.back()});
      }
      const int color = static_cast<int>(i_m);
      panel.line(fmt::format("σ_m = {:g} m", kSigma_m[i_m]), ranges, center, {.color = color});
      panel.line(i_m == 0 ? "point anywhere in it" : "", ranges, random,
                 {.color = color, .width_px = 1.2, .dash = sim::plot::Dash::kDashed});
    }
    std::vector<double> ranges, shares;
    sampled.of_attitude(i_rad, &VoxelSampled::true_model, ranges, shares);
    panel.scatter("Monte-Carlo", ranges, shares, {.color = 6, .marker = sim::plot::Marker::kCross});
  }
  experiment.write("voxel-probability.csv", csv);
  experiment.write("voxel-probability.svg", figure);
}

}  // namespace

void voxel_probability(Experiment& experiment) {
  const auto count = static_cast<std::uint32_t>(experiment.quick() ? 100000 : 1000000);
  const SampledNoise<VoxelSampled> sampled(experiment,
                                           [count](const NoiseCase& one) { return sample_voxel(one, count); });
  draw(experiment, sampled);
  const std::vector<NoiseCase>& cases = sampled.cases;

  CsvTable csv({"sigma_rad", "sigma_m", "range_m", "probability", "sampled_normal", "sampled_true"});
  double standard_errors = 0.0;
  std::array<double, 3> linearization{};
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const NoiseCase& one = cases[i];
    const double p = probability(one.range_m, one.noise(), Place::kCenter);
    csv.row({kSigma_rad[one.i_rad], kSigma_m[one.i_m], one.range_m, p, sampled.results[i].normal,
             sampled.results[i].true_model});
    // One sample of slack where p is so near 0 or 1 that no sample is expected on the other side.
    const double error = std::sqrt(p * (1.0 - p) / count);
    standard_errors =
        std::max(standard_errors, (std::abs(p - sampled.results[i].normal) - 1.0 / count) / std::max(error, 1e-12));
    linearization[one.i_rad] = std::max(linearization[one.i_rad], std::abs(p - sampled.results[i].true_model));
  }
  experiment.write("monte-carlo.csv", csv);

  const auto at = [](double range_m, double sigma_rad) {
    return probability(range_m, noise_of(0.01, sigma_rad), Place::kCenter);
  };
  experiment.at_least("right voxel at 20 m, sigma_rad 0.005, sigma_m 0.01 m", at(20.0, 0.005), 0.99, 3);
  experiment.at_most("right voxel at 40 m, sigma_rad 0.05, sigma_m 0.01 m", at(40.0, 0.05), 0.2, 3);
  experiment.at_most("right voxel at 40 m, sigma_rad 0.5, sigma_m 0.01 m", at(40.0, 0.5), 0.01, 3);
  experiment.at_most(fmt::format("probability against {:.0e} samples [standard errors]", static_cast<double>(count)),
                     standard_errors, 4.0, 2, "of the normal approximation, worst of 27 combinations");
  for (std::size_t i_rad = 0; i_rad < 3; ++i_rad) {
    experiment.row({fmt::format("linearized against true probability, sigma_rad {:g}", kSigma_rad[i_rad]),
                    short_number(linearization[i_rad], 2), Verdict::kNotJudged,
                    "largest difference: what the linearization costs", linearization[i_rad]});
  }
}

}  // namespace swiftlet::tools
