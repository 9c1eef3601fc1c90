// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/uncertainty/error_distribution.hpp"

#include <boost/math/special_functions/gamma.hpp>
#include <cmath>

namespace swiftlet {

ErrorDistribution::ErrorDistribution(const Matrix3& Sigma) {
  const double trace = Sigma.trace();
  m_ = trace * trace / (2.0 * (Sigma * Sigma).trace());  // eq. (62)
  omega_ = trace;                                        // eqs. (59), (61)
}

double ErrorDistribution::mean_m() const {
  // Gamma(m + 1/2) / Gamma(m) * sqrt(Omega / m)
  return std::sqrt(omega_ / m_) / boost::math::tgamma_delta_ratio(m_, 0.5);
}

double ErrorDistribution::variance_m2() const { return omega_ - mean_m() * mean_m(); }

double ErrorDistribution::pdf(double error_m) const {
  if (error_m <= 0.0) return 0.0;
  const double x = m_ * error_m * error_m / omega_;  // gamma-distributed with shape m and scale 1
  return boost::math::gamma_p_derivative(m_, x) * 2.0 * m_ * error_m / omega_;
}

double ErrorDistribution::cdf(double error_m) const {
  return error_m <= 0.0 ? 0.0 : boost::math::gamma_p(m_, m_ * error_m * error_m / omega_);
}

double ErrorDistribution::quantile_m(double p) const {
  return std::sqrt(omega_ / m_ * boost::math::gamma_p_inv(m_, p));
}

}  // namespace swiftlet
