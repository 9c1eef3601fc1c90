// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/imu_check.hpp"

#include <algorithm>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

/// Bounds of plausible samples. Wider bounds accept more records in wrong units.
struct ImuBounds {
  double omega_max_radps = 40.0;  ///< largest body rate; above the range of MEMS gyroscopes, 2000 deg/s
  double g_min = 0.8;             ///< smallest norm of the mean specific force that is taken for 1 g
  double g_max = 1.2;             ///< largest norm of the mean specific force that is taken for 1 g
  double down_share = 0.7;        ///< share of the mean specific force along -z from which its sign is wrong
};

std::string problem(const char* expected, double found, const char* remedy) {
  std::string text = std::string("expected ") + expected + ", found ";
  contract::append_value(text, found);
  return text + remedy;
}

}  // namespace

std::string check_imu(std::span<const ImuSample> samples) {
  constexpr ImuBounds kBounds;
  if (samples.size() < kImuCheckSamples) return "";
  Vector3 sum = Vector3::Zero();
  double omega_radps = 0.0;
  for (const ImuSample& sample : samples) {
    sum += sample.specific_force_body_mps2;
    omega_radps = std::max(omega_radps, sample.omega_body_radps.norm());
  }
  const Vector3 mean = sum / static_cast<double>(samples.size());
  const double force = mean.norm();
  if (omega_radps > kBounds.omega_max_radps)
    return problem("a body rate in rad/s", omega_radps, ": convert it if it is in deg/s");
  if (force > kBounds.g_min && force < kBounds.g_max)
    return problem("a specific force in m/s^2, 9.81 at rest", force, ": multiply it by 9.80665 if it is in g");
  if (mean.z() < -kBounds.down_share * force)
    return problem("a specific force of +9.81 m/s^2 along z at rest", mean.z(),
                   ": negate it if the driver reports gravity, or rotate it into a body frame with z up");
  return "";
}

}  // namespace swiftlet
