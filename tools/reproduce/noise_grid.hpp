// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "core/math/random.hpp"
#include "core/uncertainty/point_covariance.hpp"

/// The noise parameters of 000, section IV: eqs. (50) to (53).
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

}  // namespace swiftlet::tools
