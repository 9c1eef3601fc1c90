// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace swiftlet {

/// Mean and variance of independent samples, with the standard errors of both for a normal distribution.
class SampleStatistics {
 public:
  void add(double x) {
    ++n_;
    const double delta = x - mean_;
    mean_ += delta / n_;
    m2_ += delta * (x - mean_);
  }
  int size() const { return static_cast<int>(n_); }
  double mean() const { return mean_; }
  double variance() const { return m2_ / (n_ - 1.0); }
  double sigma() const { return std::sqrt(variance()); }

 private:
  double n_ = 0.0, mean_ = 0.0, m2_ = 0.0;
};

/// Bounds that a correct implementation misses about once in two million times: five standard errors.
inline double mean_bound(double sigma, int n) { return 5.0 * sigma / std::sqrt(static_cast<double>(n)); }
inline double variance_bound(double variance, int n) { return 5.0 * variance * std::sqrt(2.0 / n); }
inline double share_bound(double p, int n) { return 5.0 * std::sqrt(p * (1.0 - p) / n); }

}  // namespace swiftlet
