// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace swiftlet::sim::plot {

struct Tick {
  double value = 0.0;
  std::string label;  ///< empty: a minor tick
};

/// Round numbers (1, 2 or 5 times a power of ten) from low to high, about `wanted` of them.
std::vector<Tick> linear_ticks(double low, double high, int wanted);

/// Decades with minor ticks between; in ranges of less than 1.5 decades, 2 and 5 have labels too. 0 < low < high.
std::vector<Tick> log_ticks(double low, double high, int wanted);

/// Shortest decimal text with at most `decimals` places, "-0" as "0", equal on every machine.
std::string number_text(double value, int decimals);

}  // namespace swiftlet::sim::plot
