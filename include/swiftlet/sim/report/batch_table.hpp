// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "swiftlet/sim/batch/batch_config.hpp"
#include "swiftlet/sim/batch/result_store.hpp"
#include "swiftlet/sim/report/statistics.hpp"

/// The results of a batch as arrays: what its report is made of.
namespace swiftlet::sim {

/// A number that every episode has, or NaN. By episode, in the order of BatchTable::episodes.
struct Quantity {
  std::string metric;   ///< "path_length_m"
  std::string vehicle;  ///< empty: of the run; "mean": over the vehicles of the run
  std::vector<double> values;

  std::string label() const { return vehicle.empty() ? metric : metric + " (" + vehicle + ")"; }
};

/// Episodes of one point of the sweep, or of all, and one variant: what is averaged over.
struct EpisodeGroup {
  static constexpr std::size_t kAllPoints = static_cast<std::size_t>(-1);
  std::size_t point = 0;
  std::string variant;
  std::vector<std::string> parameters;
  std::vector<std::size_t> episodes;  ///< indices, in the order of their points and seeds
};

struct BatchTable {
  BatchInfo info;
  BatchConfig config;
  std::vector<EpisodeRow> episodes;  ///< without their metrics
  std::vector<EpisodeGroup> groups;  ///< by point, then in the order of the variants
  std::vector<EpisodeGroup> totals;  ///< all points together, in the order of the variants; empty with a single point
  std::vector<Quantity> quantities;
  std::vector<std::string> outcomes;  ///< that occur, sorted

  const Quantity* find(const std::string& metric, const std::string& vehicle) const;
  /// The group of the first variant at the same point, or at all; null for that variant itself.
  const EpisodeGroup* reference_of(const EpisodeGroup& group) const;
  /// "wind_mps 4, windy": what sets it apart from the other groups; the batch's name when there is one group.
  std::string name_of(const EpisodeGroup& group) const;
  /// "wind_mps 4, relief_m 0.4536", numbers rounded; "all points".
  std::string point_name(const EpisodeGroup& group) const;
};

BatchTable read_batch_table(const ResultStore& store);

std::vector<double> values_of(const Quantity& quantity, const EpisodeGroup& group);
/// The seed of each of its episodes. Over several points a seed comes up again.
std::vector<std::uint64_t> seeds_of(const BatchTable& table, const EpisodeGroup& group);
/// 1 for each episode that ended so, 0 for the others that are done, NaN for those that are not.
std::vector<double> outcomes_of(const BatchTable& table, const std::string& outcome, const EpisodeGroup& group);

/// Values of both groups for the points and seeds that both have, side by side.
struct PairedValues {
  std::vector<double> first, second;
  std::vector<std::uint64_t> seeds;
};
PairedValues paired_values(const BatchTable& table, const Quantity& quantity, const EpisodeGroup& first,
                           const EpisodeGroup& second);
/// How often `outcome` came up in either group, by seed.
PairedCounts paired_outcomes(const BatchTable& table, const std::string& outcome, const EpisodeGroup& first,
                             const EpisodeGroup& second);
std::uint64_t count_outcome(const BatchTable& table, const std::string& outcome, const EpisodeGroup& group);

/// Quantities worth a plot: those that the batch file names, otherwise six. These are the six that its groups explain
/// best, by the share of the variance that lies between them. With one group they are those that vary most.
std::vector<const Quantity*> telling_quantities(const BatchTable& table);

}  // namespace swiftlet::sim
