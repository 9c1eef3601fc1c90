// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/report/statistics.hpp"
#include "swiftlet/sim/report/batch_table.hpp"

/// Samples of the groups of a batch, for its statistics.
namespace swiftlet::sim {

std::vector<double> values_of(const Quantity& quantity, const EpisodeGroup& group);
/// Seed of each episode of the group. Over several points a seed occurs repeatedly.
std::vector<std::uint64_t> seeds_of(const BatchTable& table, const EpisodeGroup& group);
/// 1 for each episode with this outcome, 0 for other done ones, NaN for episodes that are not done.
std::vector<double> outcomes_of(const BatchTable& table, const std::string& outcome, const EpisodeGroup& group);

/// Paired values of both groups at the points and seeds that both contain.
struct PairedValues {
  std::vector<double> first, second;
  std::vector<std::uint64_t> seeds;
};
PairedValues paired_values(const BatchTable& table, const Quantity& quantity, const EpisodeGroup& first,
                           const EpisodeGroup& second);
/// Numbers of pairs with `outcome` in both groups, in one of them, and in neither. Episodes are paired by point and
/// seed; pairs with an episode that is not done are left out.
PairedCounts paired_outcomes(const BatchTable& table, const std::string& outcome, const EpisodeGroup& first,
                             const EpisodeGroup& second);
std::uint64_t count_outcome(const BatchTable& table, const std::string& outcome, const EpisodeGroup& group);

/// Quantities to plot: those named by the batch file, or else up to six. With several groups, those with the largest
/// share of variance between groups; with one group, those with the largest standard deviation relative to the mean.
std::vector<const Quantity*> informative_quantities(const BatchTable& table);

}  // namespace swiftlet::sim
