// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/suggest.hpp"

#include <algorithm>

#include "swiftlet/sim/io/nearest_word.hpp"
#include "swiftlet/sim/scenario/units.hpp"

namespace swiftlet::sim {
namespace {

std::string_view stem(std::string_view key) {
  const std::size_t underscore = key.rfind('_');
  return underscore == std::string_view::npos ? key : key.substr(0, underscore);
}

/// Recognizes `rate` or `rate_khz` instead of `rate_hz`: equal words with another unit or none.
bool differs_by_unit(std::string_view word, std::string_view candidate) {
  if (candidate == word || candidate.find('_') == std::string_view::npos) return false;
  return word == stem(candidate) || stem(word) == stem(candidate);
}

/// Recognizes `spedd` or `spedd_kmph` instead of `speed_mps`: another unit or none, with spelling mistakes.
bool is_like_without_unit(std::string_view word, std::string_view candidate) {
  if (candidate == word || unit_of_key(candidate) == nullptr) return false;
  const std::string_view bare = stem(candidate);
  const auto is_near = [&](std::string_view part) {
    const std::size_t distance = edit_distance(part, bare);
    return distance <= allowed_distance(part.size()) && distance < bare.size();
  };
  return is_near(word) || (unit_of_key(word) != nullptr && is_near(stem(word)));
}

}  // namespace

std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates) {
  constexpr std::size_t kMaxLength = 64;  // [characters] longer words have no suggestion
  if (word.empty() || word.size() > kMaxLength) return "";
  const std::string* best = nearest_word(word, candidates);
  for (const auto& is_similar : {differs_by_unit, is_like_without_unit}) {
    const auto similar = std::find_if(candidates.begin(), candidates.end(), [&](const std::string& candidate) {
      return candidate.size() <= kMaxLength && is_similar(word, candidate);
    });
    if (best == nullptr && similar != candidates.end()) best = &*similar;
  }
  return best == nullptr ? "" : "; did you mean \"" + *best + "\"?";
}

std::string one_of(const std::vector<std::string>& words) {
  constexpr std::size_t kMaxShown = 16;  // [words] further ones are left out
  if (words.empty()) return "none";
  std::string text = words.size() == 1 ? "" : "one of ";
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += ", ";
    if (i == kMaxShown) return text + "...";
    text += "\"" + words[i] + "\"";
  }
  return text;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace swiftlet::sim
