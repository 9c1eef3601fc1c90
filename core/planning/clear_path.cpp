// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/clear_path.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

#include "core/planning/met_cells.hpp"
#include "core/planning/polyline.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

/// [m] width beyond the clearance of the relaxed region around a start that is not clear. Smaller values enclose more
/// starts.
constexpr double kRelaxedMargin_m = 0.5;
/// [-] least relative gain of length for another shortening. Smaller values are slower.
constexpr double kMinGain = 1e-3;
/// [m] spacing of points from which corners are cut. Smaller values find shorter paths and are slower.
constexpr double kShorteningSpacing_m = 0.5;

Vector3 center_of(const Cell& cell, double edge_m) { return (cell.cast<double>().array() + 0.5) * edge_m; }
Cell cell_at(const Vector3& p_local_m, double edge_m) { return (p_local_m.array() / edge_m).floor().cast<int>(); }

/// Point of the segment from a to b that is nearest to p.
Vector3 nearest_on(const Vector3& a_m, const Vector3& b_m, const Vector3& p_m) {
  const Vector3 segment_m = b_m - a_m;
  const double share = segment_m.dot(p_m - a_m) / std::max(segment_m.squaredNorm(), 1e-12);
  return a_m + std::clamp(share, 0.0, 1.0) * segment_m;
}

/// Length of the shortest path on an empty grid, in cells.
double rest_of(const Cell& offset) {
  std::array<int, 3> d = {std::abs(offset.x()), std::abs(offset.y()), std::abs(offset.z())};
  std::sort(d.begin(), d.end());
  using std::numbers::sqrt2, std::numbers::sqrt3;
  return (sqrt3 - sqrt2) * d[0] + (sqrt2 - 1.0) * d[1] + d[2];
}

class ClearSearch {
 public:
  ClearSearch(const ClearSpace& space, double edge_m, const Cell& start, const Cell& goal, double heuristic_weight)
      : space_(space), edge_m_(edge_m), goal_(goal), heuristic_weight_(heuristic_weight) {
    start_ = meet(start);
    met_[start_].clear = true;  // the start counts as clear
    met_[start_].cost = 0.0;
    open_.push({rest(start_), start_});
  }

  ClearPathStatus run(int max_expansions) {
    while (!open_.empty()) {
      const int next = open_.top().node;
      open_.pop();
      if (met_[next].closed) continue;
      if (met_[next].cell == goal_) {
        end_ = next;
        return ClearPathStatus::kFound;
      }
      if (static_cast<int>(expansions_) == max_expansions) return ClearPathStatus::kBudgetSpent;
      expand(next);
    }
    return left_start_ ? ClearPathStatus::kNoPath : ClearPathStatus::kStartEnclosed;
  }

  std::vector<Cell> cells() const {
    std::vector<Cell> path;
    for (int i = end_; i >= 0; i = met_[i].parent) path.push_back(met_[i].cell);
    std::reverse(path.begin(), path.end());
    return path;
  }
  std::size_t expansions() const { return expansions_; }

 private:
  int meet(const Cell& cell) {
    return met_.meet(cell, [&](const Cell& fresh) { return space_.is_clear(center_of(fresh, edge_m_)); });
  }
  double rest(int node) const { return heuristic_weight_ * rest_of(met_[node].cell - goal_); }

  void expand(int from) {
    ++expansions_;
    met_[from].closed = true;
    left_start_ = left_start_ || !space_.near_start(center_of(met_[from].cell, edge_m_));
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (dx == 0 && dy == 0 && dz == 0) continue;
          const int to = meet(met_[from].cell + Cell(dx, dy, dz));
          const double cost = met_[from].cost + std::sqrt(static_cast<double>(dx * dx + dy * dy + dz * dz));
          if (!met_[to].clear || met_[to].closed || cost >= met_[to].cost) continue;
          met_[to].cost = cost;
          met_[to].parent = from;
          open_.push({cost + rest(to), to});
        }
      }
    }
  }

  const ClearSpace& space_;
  double edge_m_;
  Cell goal_;
  double heuristic_weight_;
  MetCells met_;
  std::priority_queue<OpenCell> open_;
  int start_ = -1, end_ = -1;
  std::size_t expansions_ = 0;
  bool left_start_ = false;
};

}  // namespace

double length_m(const std::vector<Vector3>& corners_local_m) {
  double sum_m = 0.0;
  for (std::size_t i = 1; i < corners_local_m.size(); ++i) {
    sum_m += (corners_local_m[i] - corners_local_m[i - 1]).norm();
  }
  return sum_m;
}

bool is_on_map(const Vector3& p_local_m, double edge_m) {
  return p_local_m.allFinite() && p_local_m.cwiseAbs().maxCoeff() < 1e6 * edge_m;
}

const char* text_of(ClearPathStatus status) {
  switch (status) {
    case ClearPathStatus::kFound:
      return "a path was found";
    case ClearPathStatus::kStartEnclosed:
      return "no clear space around the start";
    case ClearPathStatus::kGoalBlocked:
      return "the goal is too near to an obstacle";
    case ClearPathStatus::kGoalUnknown:
      return "the goal lies in unknown space";
    case ClearPathStatus::kGoalTooFar:
      return "the goal is farther away than a map can reach";
    case ClearPathStatus::kNoPath:
      return "no clear path to the goal";
    case ClearPathStatus::kBudgetSpent:
      return "the search for a path was given up";
  }
  return "";
}

ClearSpace::ClearSpace(const OccupancyView& view, const ClearPathConfig& config, const Vector3& start_local_m)
    : view_(view),
      clearance_m_(config.clearance_m),
      z_min_m_(config.z_min_m),
      z_max_m_(config.z_max_m),
      unknown_is_free_(config.unknown_is_free),
      start_local_m_(start_local_m),
      start_clearance_m_(0.0),
      relaxed_m_(0.0) {
  if (!is_on_map(start_local_m, view.edge_m())) return;
  start_clearance_m_ = view.clearance_m(start_local_m, clearance_m_ + view.edge_m());
  if (!is_clear(start_local_m)) relaxed_m_ = clearance_m_ + kRelaxedMargin_m;
}

bool ClearSpace::is_clear(const Vector3& p_local_m) const {
  if (relaxed_m_ > 0.0 && near_start(p_local_m)) {
    return view_.state(p_local_m) != CellState::kOccupied &&
           view_.clearance_m(p_local_m, clearance_m_ + view_.edge_m()) >= std::min(start_clearance_m_, clearance_m_);
  }
  if (p_local_m.z() < z_min_m_ || p_local_m.z() > z_max_m_) return false;
  if (!(view_.clearance_m(p_local_m, clearance_m_ + view_.edge_m()) > clearance_m_)) return false;
  return unknown_is_free_ || view_.state(p_local_m) != CellState::kUnknown;
}

bool ClearSpace::is_clear_segment(const Vector3& from_local_m, const Vector3& to_local_m) const {
  const double step_m = 0.25 * view_.edge_m();
  const int steps = std::max(1, static_cast<int>(std::ceil((to_local_m - from_local_m).norm() / step_m)));
  Cell last = Cell::Constant(std::numeric_limits<int>::max());
  for (int i = 0; i <= steps; ++i) {
    const Vector3 p_local_m = from_local_m + (to_local_m - from_local_m) * (static_cast<double>(i) / steps);
    const Cell cell = cell_at(p_local_m, view_.edge_m());
    if (cell == last) continue;
    last = cell;
    if (!is_clear(center_of(cell, view_.edge_m()))) return false;
  }
  return true;
}

ClearPathStatus refusal_reason(const OccupancyView& view, const ClearSpace& space, const ClearPathConfig& config,
                               const Vector3& start_local_m, const Vector3& goal_local_m) {
  const double edge_m = view.edge_m();
  if (!is_on_map(start_local_m, edge_m) || !is_on_map(goal_local_m, edge_m)) return ClearPathStatus::kGoalTooFar;
  if (space.is_clear(center_of(cell_at(goal_local_m, edge_m), edge_m))) return ClearPathStatus::kFound;
  const bool unknown = !config.unknown_is_free && view.state(goal_local_m) == CellState::kUnknown;
  return unknown ? ClearPathStatus::kGoalUnknown : ClearPathStatus::kGoalBlocked;
}

ClearPath find_clear_path(const OccupancyView& view, const ClearPathConfig& config, const Vector3& start_local_m,
                          const Vector3& goal_local_m) {
  const double edge_m = view.edge_m();
  const ClearSpace space(view, config, start_local_m);
  const ClearPathStatus refused = refusal_reason(view, space, config, start_local_m, goal_local_m);
  if (refused != ClearPathStatus::kFound) return {refused, {}, 0};
  const Cell start = cell_at(start_local_m, edge_m), goal = cell_at(goal_local_m, edge_m);
  ClearSearch search(space, edge_m, start, goal, config.heuristic_weight);
  const ClearPathStatus status = search.run(config.max_expansions);
  if (status != ClearPathStatus::kFound) return {status, {}, search.expansions()};
  const std::vector<Cell> cells = search.cells();
  std::vector<Vector3> path_local_m = {start_local_m};
  for (std::size_t i = 1; i + 1 < cells.size(); ++i) path_local_m.push_back(center_of(cells[i], edge_m));
  path_local_m.push_back(goal_local_m);
  return {status, shortened_path(space, std::move(path_local_m), config.max_shortenings), search.expansions()};
}

std::vector<Vector3> shortened_path(const ClearSpace& space, std::vector<Vector3> path_local_m, int times) {
  const auto is_clear = [&space](const Vector3& from_local_m, const Vector3& to_local_m) {
    return space.is_clear_segment(from_local_m, to_local_m);
  };
  for (int i = 0; i < times; ++i) {
    std::vector<Vector3> shorter_local_m =
        cut_corners(i == 0 ? path_local_m : with_points_between(path_local_m, kShorteningSpacing_m), is_clear);
    const double gained_m = length_m(path_local_m) - length_m(shorter_local_m);
    std::reverse(shorter_local_m.begin(), shorter_local_m.end());
    const bool enough = i > 1 && gained_m < kMinGain * length_m(shorter_local_m);
    path_local_m = std::move(shorter_local_m);
    if (enough) {
      if (i % 2 == 0) std::reverse(path_local_m.begin(), path_local_m.end());
      return path_local_m;
    }
  }
  if (times % 2 == 1) std::reverse(path_local_m.begin(), path_local_m.end());
  return path_local_m;
}

ClearPathConfig narrowed(const ClearPathConfig& config, double edge_m) {
  ClearPathConfig narrow = config;
  narrow.clearance_m = std::max(config.clearance_m - edge_m, 0.5 * edge_m);
  return narrow;
}

bool is_blocked(const OccupancyView& view, const ClearPathConfig& config, const Vector3& p_local_m,
                std::span<const Vector3> corners_local_m, std::size_t next) {
  ENSURE(next > 0 && next < corners_local_m.size(), next, corners_local_m.size());
  const ClearSpace space(view, narrowed(config, view.edge_m()), p_local_m);
  Vector3 from_local_m = nearest_on(corners_local_m[next - 1], corners_local_m[next], p_local_m);
  for (const Vector3& to_local_m : corners_local_m.subspan(next)) {
    if (!space.is_clear_segment(from_local_m, to_local_m)) return true;
    from_local_m = to_local_m;
  }
  return false;
}

void ClearPathConfig::visit_limits(ConfigVisitor& v) {
  v.field("clearance_m", clearance_m,
          "[m] minimum distance between cells of the path and occupied cells, center to center",
          Range{0.0, 20.0, true});
  v.field("z_min_m", z_min_m, "[m] lowest height, local frame", Range::between(-1e5, 1e5));
  v.field("z_max_m", z_max_m, "[m] greatest height, local frame", Range::between(-1e5, 1e5));
  v.check(z_max_m > z_min_m, "z_max_m", "more than z_min_m");
}

void ClearPathConfig::visit(ConfigVisitor& v) {
  visit_limits(v);
  v.field("unknown_is_free", unknown_is_free, "[-] whether a path may lead through unknown space");
  v.field("max_expansions", max_expansions, "[-] largest number of expanded cells", Range::between(1, 1e9));
}

}  // namespace swiftlet
