// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/slam/graph/closure.hpp"
#include "core/slam/graph/trajectory_graph.hpp"
#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/slam/global_slam_config.hpp"

namespace swiftlet {

/// Chooses the submaps that the newest one is compared with, adds the closures to the graph, and counts the verdicts.
class LoopCloser {
 public:
  /// @param located  whether the pose of this flight in its saved map is known
  LoopCloser(const GlobalSlamConfig& config, bool located) : config_(config), located_(located) {}

  /// Compares the newest submap with the nearest older ones that the vehicle left long ago, or that an earlier flight
  /// made. Returns the older submaps that fully constrain the pose of the newest one.
  std::vector<OlderSubmap> close_loops(TrajectoryGraph& trajectory);
  /// Relocalizes a vehicle of unknown start in the saved map by its present submap: at intervals along its path and
  /// while it hovers.
  void relocalize(TimeNs t, TrajectoryGraph& trajectory);
  /// True if a hovering vehicle searches the saved map again, with the surroundings seen while turning.
  bool is_search_due(TimeNs t, double path_length_m, const TrajectoryGraph& trajectory) const;
  bool located() const { return located_; }
  /// True when relocalization has reached its limit of attempts from one place. It resumes when the vehicle moves on.
  bool search_failed(const TrajectoryGraph& trajectory) const;

  /// Compared pairs of poses without a closure: older submap, newer submap.
  std::span<const std::pair<int, int>> refused() const { return refused_; }
  /// Forgets the refused pairs with poses that were dropped from the graph.
  void forget_refused(int first_dropped_pose);
  const ClosureCounts& loop_counts() const { return loop_counts_; }
  void append_counters(std::vector<Counter>& counters) const;

 private:
  std::vector<ClosureCandidate> candidates_of(const TrajectoryGraph& trajectory, std::vector<int>& poses) const;
  double guess_error_m(double path_length_m) const;

  GlobalSlamConfig config_;
  bool located_;
  double searched_at_m_ = 0.0;  // path length at the last attempt after moving on
  TimeNs searched_at_ = 0;      // time of the last attempt, also in hover
  double hovers_at_m_ = 0.0;    // path length at the last attempt
  int num_searches_here_ = 0;   // attempts since the vehicle moved on
  ClosureCounts loop_counts_, relocalization_counts_;
  std::vector<std::pair<int, int>> refused_;
};

}  // namespace swiftlet
