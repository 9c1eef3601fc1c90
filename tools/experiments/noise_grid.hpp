// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "parallel.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"

/// The noise parameters of [Vrba 2025, eqs. 50 to 53].
namespace swiftlet::tools {

inline constexpr std::array<double, 3> kSigma_m{0.01, 0.1, 1.0};
inline constexpr std::array<double, 3> kSigma_rad{0.005, 0.05, 0.5};
inline constexpr std::array<double, 3> kPrintedRanges_m{24.0, 48.0, 72.0};

/// diag(sigma_m, sigma_m ..., sigma_rad ...)^2, eq. (50).
inline MeasurementNoise noise_of(double sigma_m, double sigma_rad) {
  return {sigma_m, Vector3::Constant(sigma_m), Vector3::Constant(sigma_rad)};
}

/// Noise vector number `sample`, order of eq. (42).
inline Eigen::Matrix<double, 7, 1> draw_noise(const Random& random, const MeasurementNoise& noise,
                                              std::uint32_t sample) {
  const auto position = random.normal3(sample, 0), attitude = random.normal3(sample, 1);
  Eigen::Matrix<double, 7, 1> w;
  w << noise.sigma_range_m * random.normal(sample, 2), noise.sigma_position_m.cwiseProduct(Vector3(position.data())),
      noise.sigma_attitude_rad.cwiseProduct(Vector3(attitude.data()));
  return w;
}

/// One of the 27 combinations.
struct NoiseCase {
  std::size_t i_rad = 0, i_m = 0;
  double range_m = 0.0;
  MeasurementNoise noise() const { return noise_of(kSigma_m[i_m], kSigma_rad[i_rad]); }
};

/// Evaluates `sample` on every combination, in parallel on the experiment's jobs.
template <class Sampled>
struct SampledNoise {
  std::vector<NoiseCase> cases;
  std::vector<Sampled> results;

  template <class Sample>
  SampledNoise(const Experiment& experiment, Sample&& sample) {
    for (std::size_t i_rad = 0; i_rad < kSigma_rad.size(); ++i_rad) {
      for (std::size_t i_m = 0; i_m < kSigma_m.size(); ++i_m) {
        for (const double range_m : kPrintedRanges_m) cases.push_back({i_rad, i_m, range_m});
      }
    }
    results.resize(cases.size());
    parallel_for(experiment, cases.size(), "combinations", [&](std::size_t i) { results[i] = sample(cases[i]); });
  }
  /// Ranges of the combinations of one attitude noise, and a value of each result.
  template <class Value>
  void of_attitude(std::size_t i_rad, Value Sampled::*value, std::vector<double>& ranges_m,
                   std::vector<double>& values) const {
    for (std::size_t i = 0; i < cases.size(); ++i) {
      if (cases[i].i_rad != i_rad) continue;
      ranges_m.push_back(cases[i].range_m);
      values.push_back(results[i].*value);
    }
  }
};

}  // namespace swiftlet::tools
