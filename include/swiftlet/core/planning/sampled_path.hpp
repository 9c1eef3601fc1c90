// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "swiftlet/core/planning/clear_path.hpp"

namespace swiftlet {

/// Path search by random sampling. The budget is counted in samples, never in time.
struct SamplingConfig {
  double step_m = 1.0;
  double goal_share = 0.05;  ///< [-] share of the samples at the goal itself, until there is a path
  double margin_m = 10.0;
  int max_samples = 2000;  ///< [-] largest number of samples
  std::uint64_t seed = 1;

  void visit(ConfigVisitor& v);
};

enum class SampledSearch { kRrt, kInformedRrtStar };

/// Clear path by a tree that grows toward random samples.
/// - kRrt [LaValle 2001, the planner of Orsulic 2021]: the first path found.
/// - kInformedRrtStar [Gammell 2014]: the tree is rewired as it grows. Once there is a path, samples are restricted to
///   positions that can shorten it. Uses all samples; more of them never lengthen the path.
///
/// Corners are cut at the end as in find_clear_path. The search cannot prove that no path exists: it stops at its
/// budget. A pure function: equal views and draws give equal paths.
/// @param draw  number of the search; searches with other numbers draw other samples
ClearPath find_sampled_path(const OccupancyView& view, const ClearPathConfig& config, const SamplingConfig& sampling,
                            SampledSearch search, const Vector3& start_local_m, const Vector3& goal_local_m,
                            std::uint32_t draw = 0);

/// Point of the spheroid of positions through which a path between the foci has at most the given length [Gammell 2014,
/// sec. III]. Any frame, the same for all arguments. Uniform in the spheroid when `in_ball` is uniform in the unit
/// ball.
/// @param length_m  at least the distance of the foci
Vector3 point_in_spheroid(const Vector3& focus_m, const Vector3& other_focus_m, double length_m,
                          const Vector3& in_ball);

}  // namespace swiftlet
