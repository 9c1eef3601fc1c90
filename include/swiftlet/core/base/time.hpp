// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

namespace swiftlet {

/// Simulation time and durations: integer nanoseconds since the start of the run.
using TimeNs = std::int64_t;

inline constexpr TimeNs kNsPerSecond = 1'000'000'000;

constexpr double to_seconds(TimeNs t) { return static_cast<double>(t) * 1e-9; }

/// Nearest integer nanosecond.
inline TimeNs from_seconds(double seconds) { return static_cast<TimeNs>(std::llround(seconds * 1e9)); }

}  // namespace swiftlet
