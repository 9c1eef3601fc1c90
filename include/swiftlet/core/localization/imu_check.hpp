// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/base/samples.hpp"

namespace swiftlet {

/// Detects wrong units and axes of an IMU from its samples alone: the specific force by the mean of the first 50, the
/// body rate by all. The record begins at rest or in flight, in a body frame with x forward, y left, z up.
class ImuCheck {
 public:
  void add(const ImuSample& sample);
  /// The first problem, with expected and found values and a remedy; empty: none so far.
  const std::string& fault() const { return fault_; }

 private:
  void check_force(const Vector3& mean_body_mps2);

  Vector3 force_sum_body_mps2_ = Vector3::Zero();
  int num_samples_ = 0;
  int num_too_fast_ = 0;
  std::string fault_;
};

}  // namespace swiftlet
