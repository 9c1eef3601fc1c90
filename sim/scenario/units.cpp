// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/units.hpp"

#include <charconv>
#include <cmath>
#include <numbers>

#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

// Suffixes that are also parts of ordinary words (min, h, g) are no unit of a key, but may follow a number.
constexpr Unit kUnits[] = {
    {"m", "m", "a length", 1, 1},
    {"cm", "cm", "a length", 1, 100},
    {"mm", "mm", "a length", 1, 1000},
    {"um", "um", "a length", 1, 1e6},
    {"km", "km", "a length", 1000, 1},
    {"s", "s", "a time", 1, 1},
    {"ms", "ms", "a time", 1, 1000},
    {"us", "us", "a time", 1, 1e6},
    {"ns", "ns", "a time", 1, 1e9},
    {"min", "", "a time", 60, 1},
    {"h", "", "a time", 3600, 1},
    {"Hz", "hz", "a frequency", 1, 1},
    {"kHz", "khz", "a frequency", 1000, 1},
    {"MHz", "mhz", "a frequency", 1e6, 1},
    {"deg", "deg", "an angle", 1, 1},
    {"rad", "rad", "an angle", 180, std::numbers::pi},
    {"mrad", "mrad", "an angle", 0.18, std::numbers::pi},
    {"m/s", "mps", "a speed", 1, 1},
    {"cm/s", "", "a speed", 1, 100},
    {"km/h", "kmph", "a speed", 1, 3.6},
    {"m/s^2", "mps2", "an acceleration", 1, 1},
    {"m/s^3", "mps3", "a jerk", 1, 1},
    {"deg/s", "degps", "an angular speed", 1, 1},
    {"rad/s", "radps", "an angular speed", 180, std::numbers::pi},
    {"rpm", "rpm", "an angular speed", 6, 1},
    {"deg/s^2", "degps2", "an angular acceleration", 1, 1},
    {"rad/s^2", "radps2", "an angular acceleration", 180, std::numbers::pi},
    {"kg", "kg", "a mass", 1, 1},
    {"g", "", "a mass", 1, 1000},
    {"N", "N", "a force", 1, 1},
    {"mN", "mN", "a force", 1, 1000},
    {"kN", "kN", "a force", 1000, 1},
    {"Nm", "Nm", "a torque", 1, 1},
    {"mNm", "mNm", "a torque", 1, 1000},
    {"W", "W", "a power", 1, 1},
    {"mW", "mW", "a power", 1, 1000},
    {"kW", "kW", "a power", 1000, 1},
    {"V", "V", "a voltage", 1, 1},
    {"kB", "kB", "an amount of data", 1, 1},
    {"B", "", "an amount of data", 1, 1000},
    {"MB", "MB", "an amount of data", 1000, 1},
    {"kbps", "kbps", "a data rate", 1, 1},
    {"kbit/s", "", "a data rate", 1, 1},
    {"bps", "", "a data rate", 1, 1000},
    {"Mbps", "Mbps", "a data rate", 1000, 1},
    {"Mbit/s", "", "a data rate", 1000, 1},
    {"px", "px", "a number of pixels", 1, 1},
    {"m^2", "m2", "an area", 1, 1},
    {"cm^2", "cm2", "an area", 1, 1e4},
    {"m^3", "m3", "a volume", 1, 1},
    {"kg m^2", "kgm2", "a moment of inertia", 1, 1},
    {"kg/m^3", "kgpm3", "a density", 1, 1},
    {"%", "percent", "a percentage", 1, 1},
};

bool is_blank(char c) { return c == ' ' || c == '\t'; }

}  // namespace

const Unit* unit_of_key(std::string_view key) {
  const std::size_t underscore = key.rfind('_');
  if (underscore == std::string_view::npos || key.find("_per_") != std::string_view::npos) return nullptr;
  const std::string_view suffix = key.substr(underscore + 1);
  for (const Unit& unit : kUnits) {
    if (!suffix.empty() && suffix == unit.suffix) return &unit;
  }
  return nullptr;
}

const Unit* find_unit(std::string_view symbol, const Unit& unit) {
  for (const Unit& candidate : kUnits) {
    if (symbol == candidate.symbol && std::string_view(candidate.dimension) == unit.dimension) return &candidate;
  }
  return nullptr;
}

double convert(double value, const Unit& from, const Unit& to) {
  const double numerator = from.numerator * to.denominator;
  const double denominator = from.denominator * to.numerator;
  // One rounding instead of two for whole ratios: 300 ms is exactly the double nearest to 0.3.
  if (std::fmod(numerator, denominator) == 0.0) return value * (numerator / denominator);
  if (std::fmod(denominator, numerator) == 0.0) return value / (denominator / numerator);
  return value * numerator / denominator;
}

std::optional<Quantity> parse_quantity(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return Quantity{value, text};
}

std::string yaml_number(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0.0 ? ".inf" : "-.inf";
  return shortest(value);
}

}  // namespace swiftlet::sim
