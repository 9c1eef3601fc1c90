// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/next_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "core/planning/met_cells.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// The first cell along a ray that is not known to be free.
struct RayEnd {
  CellState state = CellState::kFree;
  Vector3 p_local_m = Vector3::Zero();
};
RayEnd end_of_free(const OccupancyView& view, const Vector3& from_local_m, const Vector3& direction, double range_m) {
  const int steps = static_cast<int>(range_m / view.edge_m());
  for (int i = 1; i <= steps; ++i) {
    const Vector3 p_local_m = from_local_m + i * view.edge_m() * direction;
    const CellState state = view.state(p_local_m);
    if (state != CellState::kFree) return {state, p_local_m};
  }
  return {};
}

/// Shortest paths from the start along a lattice, in order of length.
class ViewSearch {
 public:
  ViewSearch(const OccupancyView& view, const NextViewConfig& config, const WorldBox& box, const GivenUp& given_up,
             const Vector3& start_local_m)
      : view_(view),
        config_(config),
        box_(box),
        given_up_(given_up),
        start_local_m_(start_local_m),
        space_(view, config.path, start_local_m) {
    const int start = met_.meet(Cell::Zero(), [](const Cell&) { return true; });
    met_[start].cost = 0.0;
    open_.push({0.0, start});
  }

  NextView run() {
    NextView found;
    while (!open_.empty()) {
      const int next = open_.top().node;
      open_.pop();
      if (met_[next].closed) continue;
      const double path_length_m = met_[next].cost * NextViewConfig::kStep_m;
      if (value(1.0, path_length_m) <= best_) break;  // no view farther away is better
      if (static_cast<int>(expansions_) == config_.max_expansions) {
        if (end_ < 0) found.status = NextViewStatus::kBudgetSpent;
        break;
      }
      consider(next, path_length_m);
      expand(next);
    }
    found.expansions = expansions_;
    if (end_ >= 0) {
      found.status = NextViewStatus::kFound;
      found.share = share_;
      found.corners_local_m = shortened_path(space_, places(), config_.path.max_shortenings);
    } else if (found.status != NextViewStatus::kBudgetSpent && !left_start_) {
      found.status = NextViewStatus::kStartEnclosed;
    }
    return found;
  }

 private:
  double value(double share, double path_length_m) const {
    return share * elementary::exp(-config_.path_decay_per_m * path_length_m);
  }
  Vector3 place_of(const Cell& cell) const { return start_local_m_ + NextViewConfig::kStep_m * cell.cast<double>(); }

  /// Evaluates every second lattice point along each axis, which costs an eighth and finds equally good views.
  void consider(int node, double path_length_m) {
    const Cell& cell = met_[node].cell;
    if (((cell.x() | cell.y() | cell.z()) & 1) != 0 || node == 0) return;
    unknown_in_sight(view_, config_, box_, given_up_, place_of(cell), config_.num_rays, in_sight_local_m_);
    const double share = static_cast<double>(in_sight_local_m_.size()) / config_.num_rays;
    if (share < config_.share_min || value(share, path_length_m) <= best_) return;
    best_ = value(share, path_length_m);
    share_ = share;
    end_ = node;
  }

  void expand(int from) {
    ++expansions_;
    met_[from].closed = true;
    left_start_ = left_start_ || !space_.near_start(place_of(met_[from].cell));
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (dx != 0 || dy != 0 || dz != 0) reach(from, Cell(dx, dy, dz));
        }
      }
    }
  }

  void reach(int from, const Cell& step) {
    const int to = met_.meet(met_[from].cell + step, [this](const Cell& fresh) {
      const Vector3 p_local_m = place_of(fresh);
      return is_on_map(p_local_m, view_.edge_m()) && box_.holds(p_local_m) && space_.is_clear(p_local_m);
    });
    const double cost = met_[from].cost + std::sqrt(static_cast<double>(step.squaredNorm()));
    if (!met_[to].clear || met_[to].closed || cost >= met_[to].cost) return;
    if (!space_.is_clear_segment(place_of(met_[from].cell), place_of(met_[to].cell))) return;
    met_[to].cost = cost;
    met_[to].parent = from;
    open_.push({cost, to});
  }

  std::vector<Vector3> places() const {
    std::vector<Vector3> path_local_m;
    for (int i = end_; i >= 0; i = met_[i].parent) path_local_m.push_back(place_of(met_[i].cell));
    std::reverse(path_local_m.begin(), path_local_m.end());
    return path_local_m;
  }

  const OccupancyView& view_;
  const NextViewConfig& config_;
  const WorldBox& box_;
  const GivenUp& given_up_;
  Vector3 start_local_m_;
  ClearSpace space_;
  MetCells met_;
  std::priority_queue<OpenCell> open_;
  std::vector<Vector3> in_sight_local_m_;
  std::size_t expansions_ = 0;
  double best_ = 0.0, share_ = 0.0;
  int end_ = -1;
  bool left_start_ = false;
};

}  // namespace

std::uint64_t GivenUp::key_of(const Vector3& p_local_m) const {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cube = static_cast<std::int64_t>(std::floor(p_local_m[axis] / grain_m_));
    key = key << 21U | (static_cast<std::uint64_t>(cube) & 0x1FFFFFU);
  }
  return key;
}

void unknown_in_sight(const OccupancyView& view, const NextViewConfig& config, const WorldBox& box,
                      const GivenUp& given_up, const Vector3& p_local_m, int num_rays,
                      std::vector<Vector3>& found_local_m) {
  found_local_m.clear();
  const double golden_angle_rad = kPi * (3.0 - std::sqrt(5.0));  // turns between neighbors on a sphere [Vogel 1979]
  const double low = -elementary::sin(kRadPerDeg * config.down_deg), high = elementary::sin(kRadPerDeg * config.up_deg);
  for (int i = 0; i < num_rays; ++i) {
    const double rises = low + (high - low) * (i + 0.5) / num_rays, level = std::sqrt(1.0 - rises * rises);
    const double azimuth_rad = i * golden_angle_rad;
    const Vector3 direction(level * elementary::cos(azimuth_rad), level * elementary::sin(azimuth_rad), rises);
    const RayEnd end = end_of_free(view, p_local_m, direction, config.range_m);
    if (end.state == CellState::kUnknown && box.holds(end.p_local_m) && !given_up.has(end.p_local_m))
      found_local_m.push_back(end.p_local_m);
  }
}

NextView find_next_view(const OccupancyView& view, const NextViewConfig& config, const WorldBox& box,
                        const GivenUp& given_up, const Vector3& start_local_m) {
  if (!is_on_map(start_local_m, view.edge_m())) return {NextViewStatus::kStartEnclosed, {}, 0.0, 0};
  return ViewSearch(view, config, box, given_up, start_local_m).run();
}

void NextViewConfig::visit(ConfigVisitor& v) {
  v.field("range_m", range_m, "[m] range of a view within which unknown space counts", Range{0.0, 200.0, true});
  v.field("up_deg", up_deg, "[deg] upper edge of the LiDAR's field of view, above the horizon",
          Range::between(0.0, 90.0));
  v.field("down_deg", down_deg, "[deg] lower edge of the LiDAR's field of view, below the horizon",
          Range::between(0.0, 90.0));
  v.field("share_min", share_min, "[-] minimum share of a view's rays that meet unknown space for a flight to the view",
          Range{0.0, 1.0, true});
  v.field("max_expansions", max_expansions, "[-] largest number of expanded points", Range::between(1, 1e9));
  v.object("path", path, "limits of the path");
  v.check(up_deg + down_deg > 0.0, "up_deg", "more than 0, or down_deg");
}

}  // namespace swiftlet
