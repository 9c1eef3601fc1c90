// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet::sim {

/// Requests short time slices (0.1 ms) from the system, for this thread and those that it starts afterwards. When other
/// programs compete for the processors, cooperating threads get no larger share by it, but wait less for a suspended
/// thread. Needs Linux 6.12 or newer; no effect elsewhere.
void ask_for_short_time_slices();
/// Restores the system's default time slices.
void ask_for_usual_time_slices();

}  // namespace swiftlet::sim
