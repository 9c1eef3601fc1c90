// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/sim/batch/batch_config.hpp"

namespace swiftlet::sim {

/// The points of a sweep: for each the values of all parameters, in their order, as YAML texts. A pure function of the
/// configuration; a sweep without parameters has one empty point. Throws InputError.
///  - grid: all combinations, the last parameter changing fastest
/// list: the i-th value of every parameter; the lists have equal length
///  - random: independent draws
/// latin_hypercube: of n samples exactly one in each of the n equally probable intervals of every law (McKay, Beckman,
/// Conover, Technometrics 1979)
std::vector<std::vector<std::string>> sweep_points(const SweepConfig& sweep);

/// Quantile function of a law at probability `u` in (0, 1).
std::string quantile(const ParameterConfig& parameter, double u);

}  // namespace swiftlet::sim
