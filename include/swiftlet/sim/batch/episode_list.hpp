// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace swiftlet::sim {

/// Parses a list of episode numbers such as "3,17,40-50" (as `swiftlet batch --plan` prints them): ascending, without
/// duplicates.
/// @param count  number of episodes of the batch
/// Throws InputError, also when a number is not below `count`.
std::vector<std::uint64_t> parse_episodes(const std::string& text, std::uint64_t count);

}  // namespace swiftlet::sim
