// SPDX-License-Identifier: BSD-3-Clause
#include "sim/scenario/config_errors.hpp"

#include <algorithm>
#include <tuple>

namespace swiftlet::sim {
namespace {

constexpr std::size_t kMaxErrors = 20;  // lines of a message; reading ends there

std::string source_of(const Place& place) { return place.source ? place.source->name : ""; }

}  // namespace

void ConfigErrors::add(const Place& place, const std::string& path, const std::string& message) {
  std::string line = error_line(place, path, message);
  const std::string identity = place.line > 0 ? place.str() : line;
  add_once(identity, place, std::move(line));
}

void ConfigErrors::add_value(const Node& node, const std::string& path, const std::string& expected,
                             const std::string& hint) {
  std::string found = describe(node);
  if (node.is_scalar() && node.quoted) found = "the quoted text " + found;
  add(node.place, path, "expected " + expected + ", found " + found + hint);
}

void ConfigErrors::add_once(const std::string& identity, const Place& place, std::string line) {
  if (!identities_.insert(identity).second) return;
  errors_.push_back({place, std::move(line)});
  if (errors_.size() >= kMaxErrors) report();
}

void ConfigErrors::report() {
  if (errors_.empty()) return;
  const auto order = [&](const Error& error) {
    const std::string name = source_of(error.place);
    return std::make_tuple(name != source_of(root_), name, error.place.line, error.place.column);
  };
  std::stable_sort(errors_.begin(), errors_.end(), [&](const Error& a, const Error& b) { return order(a) < order(b); });
  std::string text;
  for (const Error& error : errors_) text += (text.empty() ? "" : "\n") + error.line;
  throw InputError(text);
}

}  // namespace swiftlet::sim
