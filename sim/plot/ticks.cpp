// SPDX-License-Identifier: BSD-3-Clause
#include "sim/plot/ticks.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace swiftlet::sim::plot {
namespace {

// [-] Magnitudes of the largest label between which labels have no exponent.
constexpr double kLargestPlain = 1e5;
constexpr double kSmallestPlain = 1e-4;
constexpr double kMaxMultiple = 1e12;  // larger multiples of the step are not exact

std::string power_of_ten(int exponent) {
  static constexpr std::array<const char*, 10> kDigits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = "10";
  if (exponent < 0) text += "⁻";
  for (const char digit : std::to_string(std::abs(exponent))) text += kDigits[static_cast<std::size_t>(digit - '0')];
  return text;
}

// Rounds `least` to 1, 2 or 5 times a power of ten.
double round_step(double least) {
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  const double fraction = least / power;
  return power * (fraction < 1.5 ? 1.0 : fraction < 3.5 ? 2.0 : fraction < 7.5 ? 5.0 : 10.0);
}

std::string decade_label(double mantissa, int exponent) {
  const double value = mantissa * std::pow(10.0, exponent);
  if (exponent >= -3 && exponent <= 4) return number_text(value, std::max(0, -exponent));
  const std::string power = power_of_ten(exponent);
  return mantissa == 1.0 ? power : number_text(mantissa, 0) + "·" + power;
}

}  // namespace

std::string number_text(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

std::vector<Tick> linear_ticks(double low, double high, int wanted) {
  std::vector<Tick> ticks;
  const double step = round_step((high - low) / std::max(wanted, 1));
  const int exponent = static_cast<int>(std::floor(std::log10(step) + 1e-9));
  const double largest = std::max(std::abs(low), std::abs(high));
  const bool plain = largest < kLargestPlain && largest >= kSmallestPlain;
  // Outside the range of plain numbers, all labels share the exponent of the largest.
  const int shared = plain ? 0 : static_cast<int>(std::floor(std::log10(largest)));
  if (!(step > 0.0) || !(largest / step < kMaxMultiple)) return {{low, number_text(low, 6)}};
  for (double k = std::ceil(low / step - 1e-6); k * step <= high + 1e-6 * step; ++k) {
    const double value = k * step;
    std::string label = number_text(value / std::pow(10.0, shared), std::max(0, shared - exponent));
    if (!plain && label != "0") label += "·" + power_of_ten(shared);
    ticks.push_back({value, label});
  }
  return ticks;
}

std::vector<Tick> log_ticks(double low, double high, int wanted) {
  std::vector<Tick> ticks;
  const double decades = std::log10(high / low);
  const int every = std::max(1, static_cast<int>(std::ceil(decades / std::max(wanted, 1))));
  const bool fine = decades < 1.6;
  const int first = static_cast<int>(std::floor(std::log10(low) - 1e-9)),
            last = static_cast<int>(std::ceil(std::log10(high)));
  for (int exponent = first; exponent <= last; ++exponent) {
    for (int mantissa = 1; mantissa < 10; ++mantissa) {
      const double value = mantissa * std::pow(10.0, exponent);
      if (value < low * (1.0 - 1e-9) || value > high * (1.0 + 1e-9)) continue;
      const bool decade = mantissa == 1 && exponent % every == 0;
      const bool labeled = decade || (fine && (mantissa == 1 || mantissa == 2 || mantissa == 5));
      if (mantissa != 1 && !fine && decades > 8.0) continue;
      ticks.push_back({value, labeled ? decade_label(mantissa, exponent) : std::string()});
    }
  }
  return ticks;
}

}  // namespace swiftlet::sim::plot
