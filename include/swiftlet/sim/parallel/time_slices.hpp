// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet::sim {

/// Asks the system for short turns (0.1 ms) instead of long ones, for this thread and those that it starts afterwards.
/// Beside other programs, threads that work together get no more of the processors by it, but they wait less for one
/// that is not running. Linux knows it since 6.12; elsewhere nothing happens.
void ask_for_short_time_slices();
/// As every program has them that does not ask.
void ask_for_usual_time_slices();

}  // namespace swiftlet::sim
