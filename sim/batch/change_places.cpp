// SPDX-License-Identifier: BSD-3-Clause
#include "sim/batch/change_places.hpp"

#include <fmt/format.h>

#include <optional>
#include <sstream>

namespace swiftlet::sim {
namespace {

constexpr std::string_view kMark = "--set ";

struct Found {
  Place place;
  std::string path;  // in the batch file
};

std::optional<Found> find_in_map(const Node* map, const std::string& path, const std::string& key) {
  const Place* place = map != nullptr ? place_of_key(*map, key) : nullptr;
  if (place == nullptr) return std::nullopt;
  return Found{*place, join_path(path, key)};
}

/// Later changes override earlier ones: a swept value, then those of variants, then those of all variants.
std::optional<Found> find_change(const Node& batch, const std::string& key) {
  const Node* sweep = batch.find("sweep");
  const Node* parameters = sweep != nullptr ? sweep->find("parameters") : nullptr;
  for (std::size_t i = 0; parameters != nullptr && i < parameters->items.size(); ++i) {
    const Node* swept = parameters->items[i].find("key");
    if (swept != nullptr && swept->text == key) {
      return Found{swept->place, fmt::format("sweep.parameters[{}].key: {}", i, key)};
    }
  }
  const Node* variants = batch.find("variants");
  for (std::size_t i = 0; variants != nullptr && i < variants->items.size(); ++i) {
    const Node* set = variants->items[i].find("set");
    if (auto found = find_in_map(set, fmt::format("variants[{}].set", i), key)) return found;
  }
  return find_in_map(batch.find("set"), "set", key);
}

}  // namespace

std::string with_places_of_changes(const std::string& message, const Node& batch) {
  std::string text;
  std::istringstream lines(message);
  for (std::string line; std::getline(lines, line);) {
    if (!text.empty()) text += '\n';
    const std::size_t end = line.find(": ");
    std::optional<Found> found;
    if (line.starts_with(kMark) && end != std::string::npos) {
      found = find_change(batch, line.substr(kMark.size(), end - kMark.size()));
    }
    text += found ? error_line(found->place, found->path, line.substr(end + 2)) : line;
  }
  return text;
}

}  // namespace swiftlet::sim
