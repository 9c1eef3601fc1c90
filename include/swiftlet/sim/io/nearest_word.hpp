// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// Suggestions for misspelt words.
namespace swiftlet::sim {

/// Number of insertions, deletions, replacements and swaps of adjacent letters that turn `a` into `b` (optimal string
/// alignment distance); letters that differ only in case are equal.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// Largest edit distance at which a word of this length is suggested.
std::size_t allowed_distance(std::size_t length);

/// The candidate nearest to `word`; null when none lies within the allowed distance.
const std::string* nearest_word(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace swiftlet::sim
