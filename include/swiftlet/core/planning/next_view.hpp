// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <unordered_set>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/planning/clear_path.hpp"

/// Next-best views for exploration.
namespace swiftlet {

/// Limits of the path to a view. The lattice search has a budget of its own and never enters unknown space.
struct ViewPathConfig : ClearPathConfig {
  void visit(ConfigVisitor& v) { visit_limits(v); }
};

/// Search of views. Budgets are counted, never timed, so results do not depend on the machine.
struct NextViewConfig {
  /// [m] Spacing of the lattice that is searched. Larger values search faster and miss narrow passages.
  static constexpr double kStep_m = 0.5;

  double range_m = 5.0;
  double up_deg = 45.0;
  double down_deg = 45.0;
  int num_rays = 200;  ///< [-] number of rays that evaluate a view
  double share_min = 0.1;
  double path_decay_per_m = 0.1;  ///< [1/m] lambda: decay of a view's worth with the length of its path
  int max_expansions = 200'000;
  ViewPathConfig path;

  void visit(ConfigVisitor& v);
};

/// An axis-aligned box of the world, tested with positions in the local frame.
struct WorldBox {
  Vector3 min_world_m = Vector3::Constant(-std::numeric_limits<double>::infinity());
  Vector3 max_world_m = Vector3::Constant(std::numeric_limits<double>::infinity());
  Pose T_world_local = Pose::Identity();

  bool holds(const Vector3& p_local_m) const {
    const Vector3 p_world_m = T_world_local * p_local_m;
    return (p_world_m.array() >= min_world_m.array()).all() && (p_world_m.array() <= max_world_m.array()).all();
  }
};

/// Cubes of unknown space that stayed unknown after a view.
class GivenUp {
 public:
  explicit GivenUp(double grain_m) : grain_m_(grain_m) {}
  void add(const Vector3& p_local_m) { keys_.insert(key_of(p_local_m)); }
  bool has(const Vector3& p_local_m) const { return keys_.count(key_of(p_local_m)) != 0; }
  std::size_t size() const { return keys_.size(); }

 private:
  std::uint64_t key_of(const Vector3& p_local_m) const;
  double grain_m_;
  std::unordered_set<std::uint64_t> keys_;  // only looked up, never iterated
};

/// First unknown positions in the box on rays from a point, evenly spread over the field of view of a LiDAR that
/// rotates there. Rays that first hit occupied space, and abandoned positions, are omitted.
/// @param found_local_m  cleared first
void unknown_in_sight(const OccupancyView& view, const NextViewConfig& config, const WorldBox& box,
                      const GivenUp& given_up, const Vector3& p_local_m, int num_rays,
                      std::vector<Vector3>& found_local_m);

enum class NextViewStatus { kFound, kNothingLeft, kStartEnclosed, kBudgetSpent };

struct NextView {
  NextViewStatus status = NextViewStatus::kNothingLeft;
  std::vector<Vector3> corners_local_m;  ///< clear path from the start to the view; empty when there is none
  double share = 0.0;                    ///< share of the rays from the view that end in unknown space
  std::size_t expansions = 0;            ///< number of expanded positions
};

/// Reachable position with the most visible unknown space, discounted by the path length: share * exp(-weight * length)
/// [Bircher 2016]. Positions and paths are on a lattice around the start. The search ends when no farther position can
/// be better. A pure function.
NextView find_next_view(const OccupancyView& view, const NextViewConfig& config, const WorldBox& box,
                        const GivenUp& given_up, const Vector3& start_local_m);

}  // namespace swiftlet
