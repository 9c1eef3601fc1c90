// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace swiftlet::sim {

/// "3,17,40-50": numbers of episodes, as `swiftlet batch --plan` prints them; in order, each once.
/// @param count  of all episodes
/// Throws InputError, also when a number is not below `count`.
std::vector<std::uint64_t> parse_episodes(const std::string& text, std::uint64_t count);

}  // namespace swiftlet::sim
