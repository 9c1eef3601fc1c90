// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace swiftlet::sim {

/// `; did you mean "rate_hz"?` when a candidate is near enough to `word`, otherwise empty.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates);

/// `one of "a", "b", "c"`, shortened when long; `none` when empty.
std::string one_of(const std::vector<std::string>& words);

bool contains(const std::vector<std::string>& names, const std::string& name);

}  // namespace swiftlet::sim
