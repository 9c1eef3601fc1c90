// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/grid_submaps.hpp"

namespace swiftlet {

GridSubmaps::GridSubmaps(const GridSubmapConfig& config)
    : config_(config), hit_(config.hit_probability), miss_(config.miss_probability), submaps_(2, GridSubmap(config)) {}

void GridSubmaps::insert(std::span<const Vector3> points_local_m, const Vector3& origin_local_m) {
  if (empty()) {
    begin(submaps_[older_], origin_local_m);
    num_active_ = 1;
  } else if (newer().num_scans >= config_.scans) {
    if (num_active_ == 2) older_ = 1 - older_;
    num_active_ = 2;
    begin(submaps_[1 - older_], origin_local_m);
  }
  insert(submaps_[older_], points_local_m, origin_local_m);
  if (num_active_ == 2) insert(submaps_[1 - older_], points_local_m, origin_local_m);
}

void GridSubmaps::begin(GridSubmap& submap, const Vector3& origin_local_m) {
  submap.origin_local_m = origin_local_m;
  submap.high.clear();
  submap.low.clear();
  submap.num_scans = 0;
}

void GridSubmaps::insert(GridSubmap& submap, std::span<const Vector3> points_local_m, const Vector3& origin_local_m) {
  all_m_.clear();
  near_m_.clear();
  const double near_sq = config_.high_range_max_m * config_.high_range_max_m;
  for (const Vector3& p_local_m : points_local_m) {
    all_m_.push_back(p_local_m - submap.origin_local_m);
    if ((p_local_m - origin_local_m).squaredNorm() <= near_sq) near_m_.push_back(all_m_.back());
  }
  const Vector3 origin_m = origin_local_m - submap.origin_local_m;
  submap.high.insert(near_m_, origin_m, hit_, miss_, config_.cells_missed);
  submap.low.insert(all_m_, origin_m, hit_, miss_, config_.cells_missed);
  ++submap.num_scans;
}

void GridSubmaps::clear() { num_active_ = 0; }

std::size_t GridSubmaps::bytes() const {
  std::size_t bytes = 0;
  for (const GridSubmap& submap : submaps_) bytes += submap.high.bytes() + submap.low.bytes();
  return bytes;
}

void GridSubmapConfig::visit(ConfigVisitor& v) {
  v.field("scans", scans, "[-] scans after which the next submap begins; a submap receives twice as many",
          Range::between(1, 100000));
}

}  // namespace swiftlet
