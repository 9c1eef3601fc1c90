// SPDX-License-Identifier: BSD-3-Clause
#include "sim/batch/difference.hpp"

#include <algorithm>

namespace swiftlet::sim {
namespace {

std::string changed(const std::string& path, const Node* then, const Node* now) {
  const auto shown = [](const Node* node) { return node != nullptr ? describe(*node) : "nothing"; };
  return path + ": " + shown(then) + " then, " + shown(now) + " now";
}

std::string difference_of_maps(const Node& then, const Node& now, const std::string& path) {
  for (const Entry& entry : then.entries) {
    const std::string below = join_path(path, entry.key);
    const Node* other = now.find(entry.key);
    if (other == nullptr) return changed(below, &entry.value, nullptr);
    if (std::string found = first_difference(entry.value, *other, below); !found.empty()) return found;
  }
  for (const Entry& entry : now.entries) {
    if (then.find(entry.key) == nullptr) return changed(join_path(path, entry.key), nullptr, &entry.value);
  }
  return {};
}

std::string difference_of_lists(const Node& then, const Node& now, const std::string& path) {
  for (std::size_t i = 0; i < std::max(then.items.size(), now.items.size()); ++i) {
    const std::string below = path + "[" + std::to_string(i) + "]";
    if (i >= then.items.size()) return changed(below, nullptr, &now.items[i]);
    if (i >= now.items.size()) return changed(below, &then.items[i], nullptr);
    if (std::string found = first_difference(then.items[i], now.items[i], below); !found.empty()) return found;
  }
  return {};
}

}  // namespace

std::string first_difference(const Node& then, const Node& now, const std::string& path) {
  if (then.kind != now.kind) return changed(path, &then, &now);
  if (then.is_list()) return difference_of_lists(then, now, path);
  if (then.is_scalar()) return then.text == now.text ? "" : changed(path, &then, &now);
  return difference_of_maps(then, now, path);
}

}  // namespace swiftlet::sim
