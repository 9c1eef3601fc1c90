// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

/// Numbers with units: a key's suffix gives its unit (`range_m`), a value may have another one ("20 cm").
namespace swiftlet::sim {

struct Unit {
  const char* symbol;     ///< symbol after a number: "m/s"
  const char* suffix;     ///< suffix of keys: "mps"; empty: not used in keys
  const char* dimension;  ///< "a speed"
  double numerator;       ///< this unit / first unit of its dimension = numerator / denominator
  double denominator;
};

/// The unit given by a key's suffix; null for a pure number and for compound units (`_per_`).
const Unit* unit_of_key(std::string_view key);
/// The unit with this symbol in the dimension of `unit`; null when there is none.
const Unit* find_unit(std::string_view symbol, const Unit& unit);
/// `value` of unit `from` expressed in `to`. Exact where the ratio is a whole number and the result representable.
double convert(double value, const Unit& from, const Unit& to);

/// A number and the text that follows, without blanks between: {20, "cm"}. Empty when `text` does not start with a
/// finite decimal number.
struct Quantity {
  double value;
  std::string_view unit;
};
std::optional<Quantity> parse_quantity(std::string_view text);

/// The shortest text that YAML parses back to the same double.
std::string yaml_number(double value);

}  // namespace swiftlet::sim
