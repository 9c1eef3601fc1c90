// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "swiftlet/sim/batch/batch_config.hpp"
#include "swiftlet/sim/batch/result_store.hpp"

/// The results of a batch as arrays, input of its report.
namespace swiftlet::sim {

/// A value or NaN for each episode, in the order of BatchTable::episodes.
struct Quantity {
  std::string metric;   ///< "path_length_m"
  std::string vehicle;  ///< empty: the whole run; "mean": mean over the vehicles of the run
  std::vector<double> values;

  std::string label() const { return vehicle.empty() ? metric : metric + " (" + vehicle + ")"; }
};

/// Episodes of one variant at one point of the sweep, or at all points: the samples of a mean.
struct EpisodeGroup {
  static constexpr std::size_t kAllPoints = static_cast<std::size_t>(-1);
  std::size_t point = 0;
  std::string variant;
  std::vector<std::string> parameters;
  std::vector<std::size_t> episodes;  ///< indices, sorted by point and seed
};

struct BatchTable {
  BatchInfo info;
  BatchConfig config;
  std::vector<EpisodeRow> episodes;  ///< without metrics
  std::vector<EpisodeGroup> groups;  ///< sorted by point, then in the order of the variants
  /// Groups over all points, in the order of the variants; empty with a single point
  std::vector<EpisodeGroup> totals;
  std::vector<Quantity> quantities;
  std::vector<std::string> outcomes;  ///< outcomes that occur, sorted

  const Quantity* find(const std::string& metric, const std::string& vehicle) const;
  /// The group of the first variant at the same point (or over all points); null for that variant itself.
  const EpisodeGroup* reference_of(const EpisodeGroup& group) const;
  /// Distinguishing name such as "wind_mps 4, windy"; the batch's name when there is one group.
  std::string name_of(const EpisodeGroup& group) const;
  /// Rounded parameter values such as "wind_mps 4, relief_m 0.4536"; or "all points".
  std::string point_name(const EpisodeGroup& group) const;
};

BatchTable read_batch_table(const ResultStore& store);

}  // namespace swiftlet::sim
