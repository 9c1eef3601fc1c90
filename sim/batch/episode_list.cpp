// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/episode_list.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>
#include <string_view>

#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {
namespace {

std::optional<std::uint64_t> episode_number(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::vector<std::uint64_t> parse_episodes(const std::string& text, std::uint64_t count) {
  std::set<std::uint64_t> ids;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t end = std::min(text.find(',', from), text.size());
    const std::string_view part = std::string_view(text).substr(from, end - from);
    const std::size_t dash = part.find('-');
    const auto first = episode_number(part.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : episode_number(part.substr(dash + 1));
    if (!first || !last || *last < *first)
      throw InputError("--episodes: expected numbers and ranges such as 3,17,40-50, found \"" + text + "\"");
    if (*last >= count) {
      throw InputError("--episodes: expected numbers below " + std::to_string(count) + ", found " +
                       std::to_string(*last) + "; --plan lists them");
    }
    for (std::uint64_t id = *first; id <= *last; ++id) ids.insert(id);
    from = end + 1;
  }
  return {ids.begin(), ids.end()};
}

}  // namespace swiftlet::sim
