// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <unordered_set>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/planning/clear_path.hpp"

/// Where to look next, so that a map gets whole.
namespace swiftlet {

/// How views are looked for. Budgets are counted, never timed, so the result is the same on any machine.
struct NextViewConfig {
  double range_m = 5.0;
  double up_deg = 45.0;
  double down_deg = 45.0;
  int num_rays = 200;
  double share_min = 0.1;
  double way_weight_per_m = 0.1;
  double step_m = 0.5;
  double grain_m = 0.5;
  int max_expansions = 200'000;
  ClearPathConfig path;

  void visit(ConfigVisitor& v);
};

/// A box of the world, with edges along its axes. Its places are asked for in the local frame.
struct WorldBox {
  Vector3 min_world_m = Vector3::Constant(-std::numeric_limits<double>::infinity());
  Vector3 max_world_m = Vector3::Constant(std::numeric_limits<double>::infinity());
  Pose T_world_local = Pose::Identity();

  bool holds(const Vector3& p_local_m) const {
    const Vector3 p_world_m = T_world_local * p_local_m;
    return (p_world_m.array() >= min_world_m.array()).all() && (p_world_m.array() <= max_world_m.array()).all();
  }
};

/// Cubes of unknown space that were looked at and stayed unknown.
class GivenUp {
 public:
  explicit GivenUp(double grain_m) : grain_m_(grain_m) {}
  void add(const Vector3& p_local_m) { keys_.insert(key_of(p_local_m)); }
  bool has(const Vector3& p_local_m) const { return keys_.count(key_of(p_local_m)) != 0; }
  std::size_t size() const { return keys_.size(); }

 private:
  std::uint64_t key_of(const Vector3& p_local_m) const;
  double grain_m_;
  std::unordered_set<std::uint64_t> keys_;  // asked only, never walked through
};

/// Rays from a point, spread evenly over what a LiDAR that turns sees from there. Each gives the first unknown place
/// in the box that it meets, unless something occupied comes first or that place was given up.
std::vector<Vector3> unknown_in_sight(const OccupancyView& view, const NextViewConfig& config, const WorldBox& box,
                                      const GivenUp& given_up, const Vector3& p_local_m, int num_rays);

enum class NextViewStatus { kFound, kNothingLeft, kStartEnclosed, kBudgetSpent };

struct NextView {
  NextViewStatus status = NextViewStatus::kNothingLeft;
  std::vector<Vector3> corners_local_m;  ///< a clear path from the start to the view; empty when there is none
  double share = 0.0;                    ///< of the rays from there that end in unknown space
  std::size_t expansions = 0;            ///< places that were looked at in depth
};

/// The reachable place from which most is seen that is unknown, the way there counted: share * exp(-weight * way)
/// [Bircher 2016]. Places lie on a lattice around the start, and ways along it. The search ends when no place
/// farther away can be better. A pure function.
NextView find_next_view(const OccupancyView& view, const NextViewConfig& config, const WorldBox& box,
                        const GivenUp& given_up, const Vector3& start_local_m);

}  // namespace swiftlet
