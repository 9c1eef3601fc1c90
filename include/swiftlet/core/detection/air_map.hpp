// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// A map of how often beams pass a voxel and how often they end there.
struct AirMapConfig {
  double voxel_m = 0.5;
  Eigen::Vector3d size_m = {128.0, 128.0, 64.0};
  int memory_beams = 64;
  double prior_hits = 0.02;
  double prior_passes = 0.08;

  void visit(ConfigVisitor& v);
  double bytes() const;
};

/// Where does the background return beams? Each voxel counts the beams that passed it and those that ended in it. The
/// share of a beam that reaches a voxel and is returned there has a beta distribution; its mean is the clutter share.
/// A voxel remembers a bounded number of beams: older ones fade. The box scrolls with the sensor, and what enters it is
/// unknown. Any frame, the same for all arguments.
class AirMap {
 public:
  explicit AirMap(const AirMapConfig& config);

  /// Centers the box at a place. Nothing is copied: what leaves on one side makes room for what enters on the other.
  void follow(const Vector3& center_m);
  /// A beam passed all voxels from one place to another, that of its end included.
  void pass(const Vector3& from_m, const Vector3& to_m);
  /// A beam ended here in the background. @param weight  the probability that it did, 0 to 1
  void hit(const Vector3& p_m, double weight);

  /// Mean of the clutter share of the voxel; the prior's outside.
  double clutter_share(const Vector3& p_m) const;
  /// Do fewer beams end in each of the voxels around? It takes passes to know that: the prior's share is greater.
  bool is_free_around(const Vector3& p_m, int reach_voxels, double share) const;
  /// Did a greater share of the beams end in any of the voxels around? Nothing is known to be there before.
  bool is_hit_around(const Vector3& p_m, int reach_voxels, double share) const;

  double voxel_m() const { return edge_m_; }
  double prior_share() const { return prior_share_; }

 private:
  struct Counts {
    std::uint16_t passes = 0, hits = 0;  // in 1/16 of a beam
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
  // What is too much to remember is halved, so that older beams fade.
  void add(Counts& counts, int passes, int hits) const {
    const int all_passes = counts.passes + passes, all_hits = counts.hits + hits;
    const int halved = all_passes + all_hits > most_ ? 1 : 0;
    counts.passes = static_cast<std::uint16_t>(all_passes >> halved);
    counts.hits = static_cast<std::uint16_t>(all_hits >> halved);
  }
  void forget_layers(int axis, int first, int count);

  double edge_m_, cells_per_m_;
  double prior_hits_, prior_sum_, prior_share_;
  int most_;  // of a voxel's counts
  Cell mask_, min_cell_ = Cell::Zero();
  // An index interleaves the bits of the three axes, so that what is near in space is near in memory.
  std::array<std::size_t, 3> field_mask_{};           // bits of each axis
  std::array<std::vector<std::uint32_t>, 3> fields_;  // by coordinate
  bool centered_ = false;
  std::vector<Counts> counts_;
};

}  // namespace swiftlet
