// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/suggest.hpp"

#include <algorithm>
#include <numeric>

#include "swiftlet/sim/scenario/units.hpp"

namespace swiftlet::sim {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Insertions, deletions, replacements and swaps of neighbors that turn `a` into `b` (optimal string alignment);
/// letters of another case differ by nothing.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), now(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lower(a[i - 1]) == lower(b[j - 1]);
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (same ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) now[j] = std::min(now[j], before[j - 2] + 1);
    }
    before.swap(last);
    last.swap(now);
  }
  return last[b.size()];
}

std::string_view stem(std::string_view key) {
  const std::size_t underscore = key.rfind('_');
  return underscore == std::string_view::npos ? key : key.substr(0, underscore);
}

/// `rate` or `rate_khz` where `rate_hz` is known: the same word with another unit or none.
bool differs_by_unit(std::string_view word, std::string_view candidate) {
  if (candidate == word || candidate.find('_') == std::string_view::npos) return false;
  return word == stem(candidate) || stem(word) == stem(candidate);
}

/// Mistakes that a word of so many letters may have.
std::size_t allowed_distance(std::size_t length) { return std::max<std::size_t>(1, length / 3); }

/// `spedd` or `spedd_kmph` where `speed_mps` is known: another unit or none, and mistakes besides.
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
  constexpr std::size_t kMaxLength = 64;
  if (word.empty() || word.size() > kMaxLength) return "";
  const std::string* best = nullptr;
  const std::size_t length = word.substr(0, word.rfind('.')).size();  // an extension in common is no likeness
  std::size_t best_distance = allowed_distance(length) + 1;
  for (const std::string& candidate : candidates) {
    if (candidate.empty() || candidate.size() > kMaxLength || candidate == word) continue;  // the word was refused
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance && distance < candidate.size()) {
      best = &candidate;
      best_distance = distance;
    }
  }
  for (const auto& is_meant : {differs_by_unit, is_like_without_unit}) {
    const auto meant = std::find_if(candidates.begin(), candidates.end(), [&](const std::string& candidate) {
      return candidate.size() <= kMaxLength && is_meant(word, candidate);
    });
    if (best == nullptr && meant != candidates.end()) best = &*meant;
  }
  return best == nullptr ? "" : "; did you mean \"" + *best + "\"?";
}

std::string one_of(const std::vector<std::string>& words) {
  constexpr std::size_t kMaxShown = 16;
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
