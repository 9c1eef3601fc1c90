// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "swiftlet/core/base/samples.hpp"

namespace swiftlet {

/// Number of samples from which check_imu() judges a record.
inline constexpr std::size_t kImuCheckSamples = 10;

/// Checks units and sign of the first IMU samples of a record, which begins at rest or in flight, with the body's z
/// axis up. Returns the problem with expected and found values; empty: none, or fewer than kImuCheckSamples samples.
std::string check_imu(std::span<const ImuSample> samples);

}  // namespace swiftlet
