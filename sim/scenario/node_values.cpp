// SPDX-License-Identifier: BSD-3-Clause
#include "sim/scenario/node_values.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "swiftlet/sim/scenario/units.hpp"

namespace swiftlet::sim {
namespace {

/// Expected number for messages: "a number > 0", "a whole number in [2, 6]".
std::string phrase(const Range& range, const std::string& number = "a number") {
  const bool below = std::isfinite(range.min), above = std::isfinite(range.max);
  if (below && above) {
    return number + " in " + (range.min_excluded ? "(" : "[") + yaml_number(range.min) + ", " + yaml_number(range.max) +
           (range.max_excluded ? ")" : "]");
  }
  if (below) return number + (range.min_excluded ? " > " : " >= ") + yaml_number(range.min);
  if (above) return number + (range.max_excluded ? " < " : " <= ") + yaml_number(range.max);
  return number;
}

// Larger than any physical quantity in these units; squares and counts stay representable.
constexpr double kLargest = 1e9;

/// Replaces infinite limits of the range by finite ones.
Range bounded(Range range) {
  if (std::isinf(range.min)) range.min = -kLargest;
  if (std::isinf(range.max)) range.max = std::max(kLargest, range.min);
  return range;
}

bool lies_in(const Range& range, double value) {
  return (range.min_excluded ? value > range.min : value >= range.min) &&
         (range.max_excluded ? value < range.max : value <= range.max);
}

bool is_one_of(const std::string& text, std::initializer_list<const char*> words) {
  return std::ranges::any_of(words, [&](const char* word) { return text == word; });
}

}  // namespace

void NodeValues::read(const Node& node, const std::string& path, bool& value) {
  if (node.is_scalar() && !node.quoted && (node.text == "true" || node.text == "false")) {
    value = node.text == "true";
    return;
  }
  const char* hint = is_one_of(node.text, {"yes", "Yes", "on", "On", "True", "TRUE", "1"}) ? "; did you mean \"true\"?"
                     : is_one_of(node.text, {"no", "No", "off", "Off", "False", "FALSE", "0"})
                         ? "; did you mean \"false\"?"
                         : "";
  errors_.add_value(node, path, "true or false", hint);
}

void NodeValues::read(const Node& node, const std::string& path, std::uint64_t& value) {
  std::uint64_t number = 0;
  const char* end = node.text.data() + node.text.size();
  const auto [stop, problem] = std::from_chars(node.text.data(), end, number);
  if (!node.is_scalar() || node.quoted || problem != std::errc() || stop != end)
    return errors_.add_value(node, path, "a whole number in [0, 18446744073709551615]");
  value = number;
}

bool NodeValues::read(const Node& node, const std::string& path, std::string& value) {
  if (!node.is_scalar()) {
    errors_.add_value(node, path, "a text");
    return false;
  }
  value = node.text;
  return true;
}

void NodeValues::read(const Node& node, const std::string& path, const char* key, int& value, const Range& range) {
  const std::string expected = phrase(range, "a whole number");
  constexpr double kMin = std::numeric_limits<int>::min(), kMax = std::numeric_limits<int>::max();
  const auto number = read_number(node, path, key, expected);
  if (!number) return;
  if (*number != std::floor(*number) || *number < kMin || *number > kMax || !lies_in(range, *number))
    return errors_.add_value(node, path, expected);
  value = static_cast<int>(*number);
}

void NodeValues::read(const Node& node, const std::string& path, const char* key, double& value, const Range& range) {
  const auto number = read_number(node, path, key, phrase(range));
  if (!number) return;
  if (std::isfinite(*number) && !lies_in(bounded(range), *number) && lies_in(range, *number))
    return errors_.add_value(node, path, phrase(bounded(range)));
  if (!std::isfinite(*number) || !lies_in(range, *number)) return errors_.add_value(node, path, phrase(range));
  value = *number;
}

std::optional<double> NodeValues::read_number(const Node& node, const std::string& path, const char* key,
                                              const std::string& expected) {
  const auto quantity = node.is_scalar() && !node.quoted ? parse_quantity(node.text) : std::nullopt;
  if (!quantity) {
    errors_.add_value(node, path, expected);
    return std::nullopt;
  }
  if (quantity->unit.empty()) return quantity->value;
  const Unit* unit = unit_of_key(key);
  const Unit* given = unit == nullptr ? nullptr : find_unit(quantity->unit, *unit);
  if (given == nullptr) {
    errors_.add_value(node, path, unit == nullptr ? expected : std::string(unit->dimension) + " in " + unit->symbol);
    return std::nullopt;
  }
  return convert(quantity->value, *given, *unit);
}

}  // namespace swiftlet::sim
