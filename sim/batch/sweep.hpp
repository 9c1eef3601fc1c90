// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/sim/batch/batch_config.hpp"

namespace swiftlet::sim {

/// The points of a sweep: for each the values of all parameters, in their order, as YAML texts. A pure function of the
/// configuration; a sweep without parameters has one point without values. Throws InputError.
///  - grid: all combinations, the last parameter changing fastest
///  - list: the i-th value of every parameter; the lists are equally long
///  - random: independent draws
///  - latin_hypercube: of n samples exactly one in each of the n equally probable parts of every law (McKay, Beckman,
///    Conover, Technometrics 1979)
std::vector<std::vector<std::string>> sweep_points(const SweepConfig& sweep);

/// The value that a law has at probability `u` in (0, 1): its quantile function.
std::string quantile(const ParameterConfig& parameter, double u);

}  // namespace swiftlet::sim
