// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/imu_check.hpp"

#include <algorithm>

#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/base/gravity.hpp"

namespace swiftlet {
namespace {

/// Bounds of plausible samples. Wider bounds accept more records in wrong units or axes.
struct ImuBounds {
  int start_samples = 50;         ///< averaged samples; fewer react to vibration and maneuvers at the start
  double force_min_mps2 = 4.0;    ///< norm of the mean specific force; an accelerometer in g measures 1
  double force_max_mps2 = 25.0;   ///< norm of the mean specific force, above that of flight without aerobatics
  double upward_min = 0.3;        ///< share of the mean force along z; half of the force at a tilt of 60 degrees
  double omega_max_radps = 35.0;  ///< body rate; the range of gyroscopes for vehicles is 2000 deg/s
  int too_fast_max = 20;          ///< samples above omega_max_radps, less those below; fewer react to single errors
};
constexpr ImuBounds kBounds;

template <class Value>
std::string text_of(const Value& value) {
  std::string text;
  contract::append_value(text, value);
  return text;
}

std::string problem(const std::string& expected, const Vector3& found, const std::string& remedy) {
  const Vector3 rounded = (100.0 * found).array().round() / 100.0;
  return "IMU: expected " + expected + ", found " + text_of(rounded) + "; " + remedy;
}

}  // namespace

void ImuCheck::add(const ImuSample& sample) {
  if (!fault_.empty() || !sample.omega_body_radps.allFinite() || !sample.specific_force_body_mps2.allFinite()) return;
  const bool too_fast = sample.omega_body_radps.norm() > kBounds.omega_max_radps;
  num_too_fast_ = std::max(0, num_too_fast_ + (too_fast ? 1 : -1));
  if (num_too_fast_ >= kBounds.too_fast_max)
    fault_ = problem("body rates in rad/s", sample.omega_body_radps, "convert them if they are in deg/s");
  if (num_samples_ >= kBounds.start_samples) return;
  force_sum_body_mps2_ += sample.specific_force_body_mps2;
  if (++num_samples_ == kBounds.start_samples) check_force(force_sum_body_mps2_ / kBounds.start_samples);
}

void ImuCheck::check_force(const Vector3& mean_body_mps2) {
  const double force_mps2 = mean_body_mps2.norm();
  const std::string at_rest = "a specific force of (0, 0, " + text_of(kGravity_mps2) + ") m/s^2 at rest";
  if (force_mps2 < kBounds.force_min_mps2 || force_mps2 > kBounds.force_max_mps2)
    fault_ = problem(at_rest, mean_body_mps2, "multiply it by " + text_of(kStandardGravity_mps2) + " if it is in g");
  else if (mean_body_mps2.z() < kBounds.upward_min * force_mps2)
    fault_ = problem(at_rest + " in x forward, y left, z up", mean_body_mps2,
                     "negate it if the driver reports gravity, or rotate it into the body frame");
}

}  // namespace swiftlet
