// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/base/samples.hpp"

namespace swiftlet {

/// Detects wrong units and axes of an IMU by its samples alone.
class ImuCheck {
 public:
  void add(const ImuSample& sample);
  /// Empty: nothing is wrong.
  const char* fault() const { return fault_; }

 private:
  Vector3 force_sum_body_mps2_ = Vector3::Zero();
  int num_samples_ = 0;
  int num_too_fast_ = 0;
  const char* fault_ = "";
};

}  // namespace swiftlet
