// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace swiftlet::sim {

/// Value of a metric without a sample.
inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// Root mean square and maximum of errors.
class ErrorStatistics {
 public:
  void add(double error) {
    ++count_;
    sum_of_squares_ += error * error;
    max_ = std::max(max_, std::abs(error));
  }
  double rms() const { return count_ > 0 ? std::sqrt(sum_of_squares_ / static_cast<double>(count_)) : kNotMeasured; }
  double max() const { return count_ > 0 ? max_ : kNotMeasured; }

 private:
  std::uint64_t count_ = 0;
  double sum_of_squares_ = 0.0;
  double max_ = 0.0;
};

}  // namespace swiftlet::sim
