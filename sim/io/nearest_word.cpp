// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/io/nearest_word.hpp"

#include <algorithm>
#include <numeric>

namespace swiftlet::sim {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

}  // namespace

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

std::size_t allowed_distance(std::size_t length) { return std::max<std::size_t>(1, length / 3); }

const std::string* nearest_word(std::string_view word, const std::vector<std::string>& candidates) {
  // Length above which words are not compared, which bounds the time.
  constexpr std::size_t kMaxLength = 64;
  if (word.empty() || word.size() > kMaxLength) return nullptr;
  const std::string* best = nullptr;
  const std::size_t length = word.substr(0, word.rfind('.')).size();  // a common extension is no similarity
  std::size_t best_distance = allowed_distance(length) + 1;
  for (const std::string& candidate : candidates) {
    if (candidate.empty() || candidate.size() > kMaxLength || candidate == word) continue;  // `word` itself is invalid
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance && distance < candidate.size()) {
      best = &candidate;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace swiftlet::sim
