// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace swiftlet::test {

/// Calls of operator new by all threads since the start of the program. Link tests/support/allocation_counter.cpp.
std::uint64_t num_allocations();
/// Memory allocated by operator new and not yet released [bytes].
std::int64_t num_live_bytes();

}  // namespace swiftlet::test
