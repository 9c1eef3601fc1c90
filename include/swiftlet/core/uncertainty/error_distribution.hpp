// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Distribution of the Euclidean error of a measured point, approximated by a Nakagami distribution [Vrba 2025, sec.
/// IV-B].
///
/// m = tr(Sigma)^2 / (2 tr(Sigma^2)), eq. (62); Omega = E[e^2] = tr(Sigma), eqs. (59) and (61). The paper's eq. (63)
/// prints tr(Sigma)^2 for Omega, which has the wrong unit (docs/papers.md).
class ErrorDistribution {
 public:
  /// @param Sigma  covariance of the point [m^2], positive semi-definite, not zero
  explicit ErrorDistribution(const Matrix3& Sigma);

  double shape() const { return m_; }  ///< m
  double mean_m() const;
  double variance_m2() const;
  double pdf(double error_m) const;
  double cdf(double error_m) const;
  /// Error that is exceeded with probability 1 - p, p in [0, 1).
  double quantile_m(double p) const;

 private:
  double m_ = 1.0;
  double omega_ = 1.0;
};

}  // namespace swiftlet
