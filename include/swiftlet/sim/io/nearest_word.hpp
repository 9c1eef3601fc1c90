// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// Which known word a misspelt one stands for.
namespace swiftlet::sim {

/// Insertions, deletions, replacements and swaps of neighbors that turn `a` into `b` (optimal string alignment);
/// letters of another case differ by nothing.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// Mistakes that a word of so many letters may have.
std::size_t allowed_distance(std::size_t length);

/// The candidate nearest to `word`; null when none is near enough to be meant.
const std::string* nearest_word(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace swiftlet::sim
