// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/detection/track_before_detect_config.hpp"
#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// Clutter share of each voxel: share of its beams that the background returns. Each voxel counts the beams that passed
/// it and those that ended in it. The share of the arriving beams that are returned has a beta distribution; its mean
/// is the clutter share. A voxel remembers a bounded number of beams: older ones fade. The box scrolls with the sensor;
/// voxels that enter it are unknown. Any frame, the same for all arguments.
class AirMap {
 public:
  explicit AirMap(const AirMapConfig& config);

  /// Centers the box. Nothing is copied: storage of voxels that leave is reused for those that enter.
  void follow(const Vector3& center_m);
  /// Adds a beam that passed all voxels of a segment, including the last one.
  void pass(const Vector3& from_m, const Vector3& to_m);
  /// Adds a beam that ended here. @param weight  probability that the beam ended in the background, 0 to 1
  void hit(const Vector3& p_m, double weight);

  /// Mean of the clutter share of the voxel at a position; outside the box, that of the prior.
  double clutter_share(const Vector3& p_m) const;
  /// True when the clutter share of each voxel around is at most `share`. For a `share` below that of the prior, beams
  /// must have passed each voxel.
  bool is_free_around(const Vector3& p_m, int reach_voxels, double share) const;
  /// True when the clutter share of any voxel around exceeds `share`. False for unknown voxels.
  bool is_hit_around(const Vector3& p_m, int reach_voxels, double share) const;

  double voxel_m() const { return edge_m_; }
  double prior_share() const { return prior_share_; }

 private:
  struct Counts {
    std::uint16_t passes = 0, hits = 0;  // number of beams, in units of 1/16
  };

  std::size_t index(const Cell& cell) const {
    return fields_[0][static_cast<std::size_t>(cell.x() & mask_.x())] |
           fields_[1][static_cast<std::size_t>(cell.y() & mask_.y())] |
           fields_[2][static_cast<std::size_t>(cell.z() & mask_.z())];
  }
  bool contains(const Cell& cell) const {
    return ((cell - min_cell_).array() >= 0).all() && ((cell - min_cell_).array() <= mask_.array()).all();
  }
  Cell cell_of(const Vector3& p_m) const { return (p_m.array() * cells_per_m_).floor().cast<int>(); }
  double share_of(const Counts& counts) const;
  template <class Test>
  bool any_around(const Vector3& p_m, int reach_voxels, Test&& test) const;
  // Counts beyond the memory are halved, so that older beams fade.
  void add(Counts& counts, int passes, int hits) const {
    const int all_passes = counts.passes + passes, all_hits = counts.hits + hits;
    const int halved = all_passes + all_hits > max_count_ ? 1 : 0;
    counts.passes = static_cast<std::uint16_t>(all_passes >> halved);
    counts.hits = static_cast<std::uint16_t>(all_hits >> halved);
  }
  void forget_layers(int axis, int first, int count);

  double edge_m_, cells_per_m_;
  double prior_hits_, prior_sum_, prior_share_;
  int max_count_;  // limit of the sum of a voxel's counts
  Cell mask_, min_cell_ = Cell::Zero();
  // An index interleaves the bits of the three axes, so that voxels near in space are near in memory.
  std::array<std::size_t, 3> field_mask_{};           // bits of each axis
  std::array<std::vector<std::uint32_t>, 3> fields_;  // index bits of each coordinate
  bool centered_ = false;
  std::vector<Counts> counts_;
};

}  // namespace swiftlet
