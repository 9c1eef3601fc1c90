// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "swiftlet/core/planning/clear_path.hpp"

namespace swiftlet {

/// How a path is searched by random samples. The budget is counted in samples, never in time.
struct SamplingConfig {
  double step_m = 1.0;
  double goal_share = 0.05;
  double margin_m = 10.0;
  int max_samples = 2000;
  std::uint64_t seed = 1;

  void visit(ConfigVisitor& v);
};

enum class SampledSearch { kRrt, kInformedRrtStar };

/// A clear path by a tree that grows toward random samples.
/// - kRrt [LaValle 2001, the planner of Orsulic 2021]: the first path that is found.
/// - kInformedRrtStar [Gammell 2014]: the tree is rewired as it grows. Once there is a path, samples come only from
///   where a shorter one may lead. It spends all its samples, and more of them never make the path longer.
///
/// Corners are cut in the end as by find_clear_path. It cannot tell that there is no path: it gives up. A pure
/// function: the same view and the same draw give the same path.
/// @param draw  which samples: another number, another tree
ClearPath find_sampled_path(const OccupancyView& view, const ClearPathConfig& config, const SamplingConfig& sampling,
                            SampledSearch search, const Vector3& start_local_m, const Vector3& goal_local_m,
                            std::uint32_t draw = 0);

/// A point of the ellipsoid of all places from which a way between the foci is at most so long [Gammell 2014,
/// sec. III]. Any frame, the same for all arguments. Uniform in the ellipsoid when `in_ball` is uniform in the unit
/// ball.
/// @param length_m  at least from focus to focus
Vector3 point_in_spheroid(const Vector3& focus_m, const Vector3& other_focus_m, double length_m,
                          const Vector3& in_ball);

}  // namespace swiftlet
