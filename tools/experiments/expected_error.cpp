// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "experiments.hpp"
#include "noise_grid.hpp"
#include "parallel.hpp"
#include "swiftlet/core/uncertainty/error_distribution.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kFarthest_m = 80.0;

Matrix3 covariance_at(double range_m, const MeasurementNoise& noise) {
  return point_covariance(Vector3::UnitX(), range_m, Matrix3::Identity(), noise.Sigma_w());
}

double nakagami_mean_m(double range_m, const MeasurementNoise& noise) {
  return ErrorDistribution(covariance_at(range_m, noise)).mean_m();
}

struct ErrorSampled {                           // mean errors; normal_error_m is the standard error of normal_m
  double normal_m = 0.0, normal_error_m = 0.0;  // linearized distribution
  double true_m = 0.0;                          // eqs. (38) to (41) without linearization
};

ErrorSampled sample(const NoiseCase& one, std::uint32_t count) {
  const MeasurementNoise noise = one.noise();
  const Random random(1, "expected-error", fmt::format("{}/{}/{}", one.i_rad, one.i_m, one.range_m));
  const Jacobian37 J = point_jacobian(Vector3::UnitX(), one.range_m, Matrix3::Identity());
  const Vector3 p_measured_m = one.range_m * Vector3::UnitX();
  double sum = 0.0, squares = 0.0, true_sum = 0.0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Eigen::Matrix<double, 7, 1> w = draw_noise(random, noise, i);
    const double error_sq = (J * w).squaredNorm();
    sum += std::sqrt(error_sq);
    squares += error_sq;
    true_sum += (true_point(Vector3::UnitX(), one.range_m, Pose::Identity(), w) - p_measured_m).norm();
  }
  const double n = count, mean = sum / n;
  return {mean, std::sqrt((squares / n - mean * mean) / n), true_sum / n};
}

// The first range at which the expected error reaches `error_m`; infinity: beyond the range of the figure.
double range_of_error_m(double error_m, const MeasurementNoise& noise) {
  for (double range_m = 0.0; range_m <= kFarthest_m; range_m += 0.1) {
    if (nakagami_mean_m(range_m, noise) >= error_m) return range_m;
  }
  return std::numeric_limits<double>::infinity();
}

void draw(Experiment& experiment, const SampledNoise<ErrorSampled>& sampled) {
  sim::plot::Figure figure("Expected error of a measured point (Fig. 5)", 3);
  figure.set_panel_size(400, 360);
  CsvTable csv({"sigma_rad", "sigma_m", "range_m", "expected_error_m", "exact_normal_mean_m"});
  for (std::size_t i_rad = 0; i_rad < 3; ++i_rad) {
    sim::plot::Panel& panel = figure.add_panel(fmt::format("σ_rad = {:g} rad", kSigma_rad[i_rad]));
    panel.x.label = "range [m]";
    panel.y.label = "expected error [m]";
    if (i_rad != 1) panel.legend = sim::plot::Legend::kNone;
    for (std::size_t i_m = 0; i_m < 3; ++i_m) {
      std::vector<double> ranges, errors;
      for (double range_m = 0.0; range_m <= kFarthest_m; range_m += 1.0) {
        const Matrix3 Sigma = covariance_at(range_m, noise_of(kSigma_m[i_m], kSigma_rad[i_rad]));
        ranges.push_back(range_m);
        errors.push_back(ErrorDistribution(Sigma).mean_m());
        csv.row({kSigma_rad[i_rad], kSigma_m[i_m], range_m, errors.back(), mean_normal_norm(Sigma)});
      }
      panel.line(fmt::format("σ_m = {:g} m", kSigma_m[i_m]), ranges, errors, {.color = static_cast<int>(i_m)});
    }
    std::vector<double> ranges, means;
    sampled.of_attitude(i_rad, &ErrorSampled::true_m, ranges, means);
    panel.scatter("Monte-Carlo", ranges, means, {.color = 6, .marker = sim::plot::Marker::kCross});
  }
  experiment.write("expected-error.csv", csv);
  experiment.write("expected-error.svg", figure);
}

}  // namespace

void expected_error(Experiment& experiment) {
  const auto count = static_cast<std::uint32_t>(experiment.quick() ? 100000 : 1000000);
  const SampledNoise<ErrorSampled> sampled(experiment, [count](const NoiseCase& one) { return sample(one, count); });
  draw(experiment, sampled);
  const std::vector<NoiseCase>& cases = sampled.cases;

  CsvTable csv({"sigma_rad", "sigma_m", "range_m", "nakagami_m", "exact_m", "sampled_normal_m", "standard_error_m",
                "sampled_true_m"});
  double standard_errors = 0.0, nakagami = 0.0;
  std::array<double, 3> linearization{};
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const NoiseCase& one = cases[i];
    const Matrix3 Sigma = covariance_at(one.range_m, one.noise());
    const double exact_m = mean_normal_norm(Sigma), approximate_m = ErrorDistribution(Sigma).mean_m();
    csv.row({kSigma_rad[one.i_rad], kSigma_m[one.i_m], one.range_m, approximate_m, exact_m, sampled.results[i].normal_m,
             sampled.results[i].normal_error_m, sampled.results[i].true_m});
    standard_errors =
        std::max(standard_errors, std::abs(exact_m - sampled.results[i].normal_m) / sampled.results[i].normal_error_m);
    nakagami = std::max(nakagami, std::abs(approximate_m / exact_m - 1.0));
    linearization[one.i_rad] = std::max(linearization[one.i_rad], std::abs(exact_m / sampled.results[i].true_m - 1.0));
  }
  experiment.write("monte-carlo.csv", csv);

  for (const double sigma_rad : {0.05, 0.5}) {
    experiment.at_most(fmt::format("range at which 2 m are expected, sigma_rad {:g} [m]", sigma_rad),
                       range_of_error_m(2.0, noise_of(0.01, sigma_rad)), 50.0, 3);
  }
  experiment.at_most(fmt::format("expected error against {:.0e} samples [standard errors]", static_cast<double>(count)),
                     standard_errors, 4.0, 2, "exact mean of the normal approximation, worst of 27 combinations");
  experiment.at_most("Nakagami's mean against the exact one [share]", nakagami, 0.01, 2,
                     "the price of eqs. 61 to 63, worst of 27");
  for (std::size_t i_rad = 0; i_rad < 3; ++i_rad) {
    const bool small = kSigma_rad[i_rad] < 0.4;
    const std::string what = fmt::format("linearized against true mean, sigma_rad {:g} [share]", kSigma_rad[i_rad]);
    if (small) {
      experiment.at_most(what, linearization[i_rad], 0.01, 2);
    } else {
      experiment.row({what, short_number(linearization[i_rad], 2), Verdict::kNotJudged,
                      "half a radian is no small angle: the linearized error is too large by this",
                      linearization[i_rad]});
    }
  }
}

}  // namespace swiftlet::tools
